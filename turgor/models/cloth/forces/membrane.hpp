// Membrane of a sheet: linear triangles of an orthotropic material in co-rotated (Biot) strain. The energy
// per rest area is
//
//   Ψ = ½ (U − 1) : D (U − 1),     U² = FᵀF
//
// with F (3×2) the deformation gradient from warp and weft at rest to space. Ψ depends on the side lengths
// only, so forces act along the sides. The stiffness does not depend on the mesh. Equations:
// docs/models/cloth.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"
#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

struct Fabric;
struct Model;
struct State;

/// Unit directions of warp and weft in the plane of a triangle. If the warp is normal to the plane, any
/// direction.
struct Weave {
  Vec3d warp, weft;
};
Weave weave_at(Vec3d direction, Vec3d normal);

/// Membrane of a mesh at rest, without slots. `is_sliver`: of each triangle (slivers.hpp).
Membrane make_membrane(const TriMesh& mesh, const Fabric& fabric, std::span<const char> is_sliver);

/// Springs along all edges that are together at least as stiff as the membrane; the matrix of a step uses
/// them. Rest lengths are not set. Slivers have no stiffness.
std::vector<Spring> membrane_springs(const TriMesh& mesh, const Fabric& fabric,
                                     std::span<const char> is_sliver);

/// Finds the entries of the triangles' sides in rows of the same numbering.
void find_slots(const std::vector<Int3>& triangles, const Rows& rows, Membrane& membrane);

/// Writes the tension of every edge, force over length, to System::across [N/m].
void find_tensions(const Exec& exec, const Model& model, State& state);

/// Tensions of the three sides of a triangle [N/m] and its energy [J], in double precision.
struct TriangleTension {
  std::array<double, 3> side{};
  double energy = 0;
};
TriangleTension triangle_tension(const Model& model, const State& state, std::size_t triangle);

}  // namespace turgor::cloth

// The membrane of a sheet: linear triangles of an orthotropic material in co-rotated (Biot) strain, U − 1
// with U² = FᵀF. Whatever the mesh, a pull is answered as the fabric says. A triangle's forces run along its
// sides, so that three tensions are all there is to know of it. Equations: docs/models/cloth.md.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

struct Fabric;
struct Model;
struct State;

/// σ = D ε by warp and weft: D₁₁, D₂₂, D₁₂, G [N/m].
struct MembraneLaw {
  Real warp = 0, weft = 0, both = 0, shear = 0;
};

/// The law, and the triangles at rest. Arrays are padded to whole batches of triangles.
struct Membrane {
  MembraneLaw law;
  /// Gradients of the shape functions of the second and third corner, along warp and weft [1/m].
  aligned_vector<Real> second[2], third[2];
  /// Where the tensions of the sides go: the slots in the rows of the first and the second vertex of side 0,
  /// 1 and 2, counted from the first of their batch.
  std::vector<std::array<std::uint8_t, 6>> slot;
  std::vector<std::array<std::uint16_t, 6>> wide_slot;  // instead, where a batch has more slots than 256
};

/// Warp and weft in the plane of a triangle, unit vectors. Where the warp stands on it, some direction.
struct Weave {
  Vec3d warp, weft;
};
Weave weave_at(Vec3d direction, Vec3d normal);

/// The triangles of a mesh at rest, without slots.
Membrane make_membrane(const TriMesh& mesh, const Fabric& fabric);

/// One spring along every edge that is at least as stiff as the membrane: what the matrix of a step is made
/// of. Its length at rest is left out.
std::vector<Spring> membrane_springs(const TriMesh& mesh, const Fabric& fabric);

/// Where the sides of the triangles are in rows of the same numbering.
void find_slots(const std::vector<Int3>& triangles, const Rows& rows, Membrane& membrane);

/// Puts the tension of every edge, force over length, into System::across [N/m].
void find_tensions(const Exec& exec, const Model& model, State& state);

/// Tensions of the sides of one triangle [N/m] and its energy [J], in double precision.
struct TriangleTension {
  std::array<double, 3> side{};
  double energy = 0;
};
TriangleTension triangle_tension(const Model& model, const State& state, std::size_t triangle);

}  // namespace turgor::cloth

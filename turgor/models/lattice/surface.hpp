// The surface that is drawn: the skin as a smooth isosurface of the CT inside the lattice, and the walls of wounds. Every
// vertex is carried by one node, on its own side of a cut, so that a closed cut is invisible and an open one is clean.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct BodySurface {
  std::vector<Vec3> rest;       // vertices as in the CT, lattice frame [m]
  std::vector<int> slot;        // the node that carries each vertex
  std::vector<Int3> triangles;  // skin first, then walls
  int skin_triangles = 0;
};

/// What colours the skin.
enum class Shown : std::uint8_t { kNothing, kDisplacement, kStretch };

BodySurface build_surface(const Model& model, const State& state);
/// The surface where the body is now, in the patient frame [m], with smooth normals (walls and skin apart) and a
/// scalar a vertex: displacement [m], or the skin's area ratio A / A_CT − 1.
TriMesh deformed_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown);

}  // namespace turgor::lattice

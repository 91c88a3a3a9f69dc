// The surface that is drawn: the skin as a smooth isosurface of the CT inside the lattice, flat caps where
// the scan ends, and the walls of wounds. Every vertex is carried by one node, on its own side of a cut, so
// that a closed cut is invisible and an open one is clean.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct BodySurface {
  std::vector<Vec3> rest;       // vertices as in the CT, lattice frame [m]
  std::vector<int> slot;        // the node that carries each vertex
  std::vector<int> twin;        // the vertex on the other lip of a cut where they met; -1 = none
  std::vector<Int3> triangles;  // skin first (caps last among it), then walls
  int skin_triangles = 0;
};

/// What colours the skin.
enum class Shown : std::uint8_t { kNothing, kDisplacement, kStretch };

/// The surface of the body in the CT, with the state's cuts and removed nodes; to be made again when those
/// change.
BodySurface build_surface(const Model& model, const State& state);
/// The surface where the body is now, in the patient frame [m], with smooth normals (walls, caps and skin
/// apart) and a scalar a vertex: displacement [m], or the skin's area ratio A / A_CT − 1.
TriMesh deformed_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown);
/// Where the CT shows what each vertex is made of, patient frame [m].
std::vector<Vec3d> rest_points(const Model& model, const BodySurface& surface);

}  // namespace turgor::lattice

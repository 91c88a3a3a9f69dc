// A fine surface, as one sees it, carried by a coarse mesh, as it is computed: every vertex of the surface
// hangs on the corners of one element by fixed weights.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct Embedding {
  std::vector<Vec3> rest;  // the surface's vertices where nothing is displaced [m]
  int corners = 4;
  std::vector<int> nodes;       // `corners` vertices of the mesh for every vertex of the surface
  std::vector<float> weights;   // of each: barycentric or trilinear, their sum is 1
  double farthest_outside = 0;  // how far a vertex is outside the mesh, at most [m]
};

/// Vertices outside the mesh hang on the element behind the nearest point of its surface, extrapolated. The
/// mesh has at least one element.
Embedding embed(const Exec& exec, const TriMesh& surface, const SolidMesh& mesh);

/// Where the surface's vertices are once the mesh's are displaced [m]. Neither allocates nor locks.
void move(const Embedding& embedding, std::span<const Vec3d> displacements, std::span<Vec3> vertices);

}  // namespace turgor

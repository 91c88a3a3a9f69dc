// Embedding of a fine surface in a coarse mesh: every surface vertex follows the corners of one element by
// fixed barycentric or trilinear weights.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct Embedding {
  std::vector<Vec3> rest;  // surface vertices in the undeformed state [m]
  int corners = 4;
  std::vector<int> nodes;       // `corners` mesh vertices for every surface vertex
  std::vector<float> weights;   // barycentric or trilinear, with sum 1
  double farthest_outside = 0;  // largest distance of a vertex outside the mesh [m]
};

/// Vertices outside the mesh are extrapolated from the element behind the nearest point of its surface. The
/// mesh has at least one element.
Embedding embed(const Exec& exec, const TriMesh& surface, const SolidMesh& mesh);

/// Positions of the surface vertices for displaced mesh vertices [m]. Neither allocates nor locks.
void move(const Embedding& embedding, std::span<const Vec3d> displacements, std::span<Vec3> vertices);

}  // namespace turgor

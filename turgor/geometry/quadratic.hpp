// Quadratic tetrahedra (ten nodes: corners and edge midpoints): conversion from and to linear ones, shape
// function gradients, and subdivision into eight linear tetrahedra.
#pragma once

#include <array>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Corners at the ends of the edges of midside nodes 4 to 9, as in VTK.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

/// Midside node between two corners.
constexpr int node_between(int a, int b) {
  for (int e = 0; e < 6; e++) {
    const auto [from, to] = kTetEdges[std::size_t(e)];
    if ((from == a && to == b) || (from == b && to == a)) return 4 + e;
  }
  return -1;
}

/// Gradients of the ten quadratic shape functions with respect to barycentric coordinates 1, 2 and 3, at the
/// point with these four barycentric coordinates.
std::array<Vec3d, 10> quadratic_slopes(const std::array<double, 4>& linear);

/// Adds midside nodes with straight edges. Vertices keep their numbers; midside nodes follow.
SolidMesh with_middles(const SolidMesh& tetrahedra);

/// Drops midside nodes; vertices keep their numbers.
SolidMesh without_middles(const SolidMesh& quadratic);

/// Splits every quadratic tetrahedron into eight linear ones between its ten nodes.
SolidMesh linear_subdivision(const SolidMesh& quadratic);

}  // namespace turgor

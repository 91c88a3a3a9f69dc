// Tetrahedra with a node in the middle of every edge, and the linear ones that such nodes make: what
// quadratic elements, and a mesh refined all over, are built from.
#pragma once

#include <array>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// The corners at the ends of the edges whose middles are nodes 4 to 9 of a quadratic tetrahedron, as in VTK.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

/// The node of a quadratic tetrahedron between two of its corners.
constexpr int node_between(int a, int b) {
  for (int e = 0; e < 6; e++) {
    const auto [from, to] = kTetEdges[std::size_t(e)];
    if ((from == a && to == b) || (from == b && to == a)) return 4 + e;
  }
  return -1;
}

/// The slopes of a quadratic tetrahedron's ten functions over its linear functions 1, 2 and 3, where the four
/// linear ones have these values.
std::array<Vec3d, 10> quadratic_slopes(const std::array<double, 4>& linear);

/// Linear tetrahedra as quadratic ones with straight edges. Vertices keep their numbers; the middles of edges
/// come behind them.
SolidMesh with_middles(const SolidMesh& tetrahedra);

/// The tetrahedra between the corners of quadratic ones; vertices keep their numbers, the middles are left
/// out.
SolidMesh without_middles(const SolidMesh& quadratic);

/// Every quadratic tetrahedron as eight linear ones between its ten nodes.
SolidMesh linear_parts(const SolidMesh& quadratic);

}  // namespace turgor

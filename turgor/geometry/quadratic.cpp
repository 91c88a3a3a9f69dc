#include "turgor/geometry/quadratic.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor {

namespace {

using Edge = std::array<int, 2>;  // vertices, ascending

Edge edge_of(std::span<const int> element, const std::array<int, 2>& corners) {
  const int a = element[std::size_t(corners[0])], b = element[std::size_t(corners[1])];
  return {std::min(a, b), std::max(a, b)};
}

/// Every edge once, in ascending order.
std::vector<Edge> all_edges(const SolidMesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(6 * element_count(mesh));
  for (std::size_t e = 0; e < element_count(mesh); e++)
    for (const auto& corners : kTetEdges) edges.push_back(edge_of(element(mesh, e), corners));
  sort_unique(edges);
  return edges;
}

}  // namespace

std::array<Vec3d, 10> quadratic_slopes(const std::array<double, 4>& linear) {
  static constexpr std::array<Vec3d, 4> kSlope{{{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<Vec3d, 10> slope;
  for (std::size_t c = 0; c < 4; c++) slope[c] = kSlope[c] * (4 * linear[c] - 1);
  for (std::size_t e = 0; e < kTetEdges.size(); e++) {
    const auto a = std::size_t(kTetEdges[e][0]), b = std::size_t(kTetEdges[e][1]);
    slope[4 + e] = 4 * (linear[a] * kSlope[b] + linear[b] * kSlope[a]);
  }
  return slope;
}

SolidMesh with_middles(const SolidMesh& tetrahedra) {
  TURGOR_ASSERT(tetrahedra.corners == 4, "midside nodes are added to linear tetrahedra");
  const std::vector<Edge> edges = all_edges(tetrahedra);
  SolidMesh mesh{tetrahedra.vertices, 10, {}, tetrahedra.regions};
  const int first = int(mesh.vertices.size());
  for (const auto [a, b] : edges)
    mesh.vertices.push_back((mesh.vertices[std::size_t(a)] + mesh.vertices[std::size_t(b)]) / 2);
  for (std::size_t e = 0; e < element_count(tetrahedra); e++) {
    const std::span<const int> corners = element(tetrahedra, e);
    mesh.elements.insert(mesh.elements.end(), corners.begin(), corners.end());
    for (const auto& ends : kTetEdges) {
      const auto found = std::lower_bound(edges.begin(), edges.end(), edge_of(corners, ends));
      mesh.elements.push_back(first + int(found - edges.begin()));
    }
  }
  return mesh;
}

SolidMesh without_middles(const SolidMesh& quadratic) {
  TURGOR_ASSERT(quadratic.corners == 10, "the mesh has quadratic tetrahedra");
  SolidMesh mesh{{}, 4, {}, quadratic.regions};
  int most = -1;
  for (std::size_t e = 0; e < element_count(quadratic); e++)
    for (const int corner : element(quadratic, e).first(4)) {
      mesh.elements.push_back(corner);
      most = std::max(most, corner);
    }
  mesh.vertices.assign(quadratic.vertices.begin(), quadratic.vertices.begin() + most + 1);
  return mesh;
}

SolidMesh linear_subdivision(const SolidMesh& quadratic) {
  TURGOR_ASSERT(quadratic.corners == 10, "quadratic tetrahedra are subdivided");
  // a tetrahedron at every corner; the octahedron between them is split around the diagonal from node 6 to
  // node 8
  static constexpr int kSubTets[8][4] = {{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3},
                                         {6, 8, 4, 5}, {6, 8, 5, 9}, {6, 8, 9, 7}, {6, 8, 7, 4}};
  SolidMesh mesh{quadratic.vertices, 4, {}, {}};
  for (std::size_t e = 0; e < element_count(quadratic); e++)
    for (const auto& tet : kSubTets) {
      for (const int node : tet) mesh.elements.push_back(element(quadratic, e)[std::size_t(node)]);
      if (!quadratic.regions.empty()) mesh.regions.push_back(quadratic.regions[e]);
    }
  return mesh;
}

}  // namespace turgor

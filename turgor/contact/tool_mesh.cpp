// Converts a closed mesh into a shape: exact distances at the nodes of a grid, and surface points that are
// tested against large triangles.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "turgor/contact/tool.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/geometry/signed_distance.hpp"

namespace turgor::contact {

namespace {

/// Error text for a mesh that is not a closed surface; empty for a valid mesh.
std::string mesh_fault(const TriMesh& mesh) {
  // triangles and finite vertices
  const int count = int(mesh.vertices.size());
  if (mesh.triangles.empty()) return "a mesh tool has no triangles";
  for (std::size_t v = 0; v < mesh.vertices.size(); v++)
    if (const Vec3 x = mesh.vertices[v]; !std::isfinite(x.x + x.y + x.z))
      return "vertex " + std::to_string(v) + " of a mesh tool is not finite";
  // directed edges
  std::vector<std::pair<int, int>> edges;
  for (const auto [a, b, c] : mesh.triangles) {
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
      if (from < 0 || from >= count)
        return "a mesh tool refers to vertex " + std::to_string(from) + " of " + std::to_string(count);
      edges.emplace_back(from, to);
    }
  }
  // every edge needs its opposite, once
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); i++) {
    const auto [from, to] = edges[i];
    const bool twice = i > 0 && edges[i - 1] == edges[i];
    if (twice || !std::binary_search(edges.begin(), edges.end(), std::pair{to, from}))
      return "a mesh tool is not closed: expected each edge in two triangles, once in each direction, found "
             "otherwise from vertex " +
             std::to_string(from) + " to vertex " + std::to_string(to);
  }
  return {};
}

/// Points far from each other: each is the one farthest from those chosen before.
std::vector<Vec3d> farthest_points(const std::vector<Vec3d>& all, std::size_t count) {
  TURGOR_CHECK(!all.empty(), "test points are chosen from at least one point");
  std::vector<double> nearest(all.size(), HUGE_VAL);
  std::vector<Vec3d> chosen;
  std::size_t next = 0;
  while (chosen.size() < count && nearest[next] > 0) {
    chosen.push_back(all[next]);
    for (std::size_t i = 0; i < all.size(); i++)
      nearest[i] = std::min(nearest[i], dot(all[i] - chosen.back(), all[i] - chosen.back()));
    next = std::size_t(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
  }
  return chosen;
}

/// Corners, edge midpoints and centers of all triangles.
std::vector<Vec3d> surface_points(const TriMesh& mesh) {
  std::vector<Vec3d> points;
  const auto x = [&](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
  for (const auto [a, b, c] : mesh.triangles)
    for (const Vec3d position : {x(a), x(b), x(c), (x(a) + x(b)) / 2, (x(b) + x(c)) / 2, (x(c) + x(a)) / 2,
                                 (x(a) + x(b) + x(c)) / 3})
      points.push_back(position);
  return points;
}

/// Sets normals by central differences of the distances.
void fill_normals(MeshShape& m) {
  const auto at = [&](int i, int j, int k) -> MeshShape::Node& {
    return m.nodes[std::size_t((std::clamp(k, 0, m.size.z - 1) * m.size.y + std::clamp(j, 0, m.size.y - 1)) *
                                   m.size.x +
                               std::clamp(i, 0, m.size.x - 1))];
  };
  for (int k = 0; k < m.size.z; k++)
    for (int j = 0; j < m.size.y; j++)
      for (int i = 0; i < m.size.x; i++)
        at(i, j, k).normal = normalized(Vec3{at(i + 1, j, k).distance - at(i - 1, j, k).distance,
                                             at(i, j + 1, k).distance - at(i, j - 1, k).distance,
                                             at(i, j, k + 1).distance - at(i, j, k - 1).distance});
}

}  // namespace

Result<Shape> mesh_shape(const TriMesh& mesh, int resolution) {
  TURGOR_ASSERT(resolution >= 4 && resolution <= 128,
                "a mesh tool's grid has 4 to 128 cells along its longest side");
  if (const std::string wrong = mesh_fault(mesh); !wrong.empty()) return Error{wrong};
  // grid around the mesh
  const SignedDistance exact = distance_to_surface(mesh);
  MeshShape m;
  const Vec3d sides = exact.high - exact.low;
  m.spacing = std::max({sides.x, sides.y, sides.z}) / resolution;
  if (!(m.spacing > 0)) return Error{"a mesh tool has no extent: all of its vertices coincide"};
  constexpr int kBorder = 4;  // cells around the mesh, where contact begins
  m.corner = exact.low - Vec3d{1, 1, 1} * (kBorder * m.spacing);
  for (int axis = 0; axis < 3; axis++)
    m.size[axis] = int(std::ceil(sides[axis] / m.spacing)) + 2 * kBorder + 1;
  // distances and normals
  for (int k = 0; k < m.size.z; k++)
    for (int j = 0; j < m.size.y; j++)
      for (int i = 0; i < m.size.x; i++)
        m.nodes.push_back({float(exact.at(m.corner + Vec3d(Int3{i, j, k}) * m.spacing)), {}});
  TURGOR_CHECK(m.nodes.size() == std::size_t(m.size.x) * std::size_t(m.size.y) * std::size_t(m.size.z),
               "the distance grid has a value at every node");
  fill_normals(m);
  // test points and radii
  constexpr std::size_t kTips = 32;
  m.tips = farthest_points(surface_points(mesh), kTips);
  for (const Vec3 v : mesh.vertices) m.bounding_radius = std::max(m.bounding_radius, norm(Vec3d(v)));
  m.tip_radius = std::min({sides.x, sides.y, sides.z}) / 2;
  return Shape(std::move(m));
}

}  // namespace turgor::contact

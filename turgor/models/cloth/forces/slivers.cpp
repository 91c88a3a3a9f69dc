#include "turgor/models/cloth/forces/slivers.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"

namespace turgor::cloth {

namespace {

/// Height over the longest side [m].
double height(const TriMesh& mesh, Int3 t) {
  const auto at = [&mesh](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
  const Vec3d p = at(t.y) - at(t.x), q = at(t.z) - at(t.x);
  const double longest = std::max({norm(p), norm(q), norm(q - p)});
  TURGOR_CHECK(longest > 0, "a triangle has sides");
  return norm(cross(p, q)) / longest;
}

}  // namespace

std::vector<char> find_slivers(const TriMesh& mesh) {
  constexpr double kThin = 0.1;  // height relative to that of the triangles around
  // heights, summed at the vertices
  std::vector<double> heights, sum(mesh.vertices.size(), 0), count(mesh.vertices.size(), 0);
  for (const Int3 t : mesh.triangles) {
    heights.push_back(height(mesh, t));
    for (int k = 0; k < 3; k++) sum[std::size_t(t[k])] += heights.back(), count[std::size_t(t[k])] += 1;
  }
  // heights relative to the means at the corners
  std::vector<char> is_sliver(mesh.triangles.size(), 0);
  for (std::size_t n = 0; n < is_sliver.size(); n++) {
    double around = 0;
    for (int k = 0; k < 3; k++) {
      const auto v = std::size_t(mesh.triangles[n][k]);
      around = std::max(around, sum[v] / count[v]);
    }
    is_sliver[n] = heights[n] < kThin * around;
  }
  // a vertex of slivers only needs them
  std::vector<char> is_carried(mesh.vertices.size(), 0);
  for (std::size_t n = 0; n < is_sliver.size(); n++)
    for (int k = 0; k < 3; k++)
      if (is_sliver[n] == 0) is_carried[std::size_t(mesh.triangles[n][k])] = 1;
  for (std::size_t n = 0; n < is_sliver.size(); n++)
    for (int k = 0; k < 3; k++)
      if (is_carried[std::size_t(mesh.triangles[n][k])] == 0) is_sliver[n] = 0;
  return is_sliver;
}

}  // namespace turgor::cloth

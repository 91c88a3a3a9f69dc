#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/geometry/triangle_tree.hpp"

namespace turgor {

namespace {

using Corners = std::array<Vec3d, 3>;

/// Side of the plane abc on which a point is; 0 within rounding error.
int side_of(Vec3d a, Vec3d b, Vec3d c, Vec3d p) {
  const double volume = orientation(a, b, c, p);
  const double doubtful = 1e-12 * norm(b - a) * norm(c - a) * norm(p - a);
  return volume > doubtful ? 1 : volume < -doubtful ? -1 : 0;
}

/// True if pq meets the plane of t inside t, within rounding error.
bool meets_within(Vec3d p, Vec3d q, const Corners& t) {
  const double from = orientation(t[0], t[1], t[2], p), to = orientation(t[0], t[1], t[2], q);
  const Vec3d position = p + (q - p) * (from / (from - to));
  return nearest_on_triangle(position, t[0], t[1], t[2]).distance <= 1e-9 * norm(q - p);
}

bool passes_through(Vec3d p, Vec3d q, const Corners& t) {
  if (side_of(t[0], t[1], t[2], p) * side_of(t[0], t[1], t[2], q) >= 0) return false;
  const int u = side_of(p, q, t[0], t[1]), v = side_of(p, q, t[1], t[2]), w = side_of(p, q, t[2], t[0]);
  if ((u > 0 || v > 0 || w > 0) && (u < 0 || v < 0 || w < 0)) return false;
  // Through an edge or a corner. If all points are coplanar within 1e-12 of their size, the segment may still
  // be far from the triangle.
  return u * v * w != 0 || meets_within(p, q, t);
}

/// True if an edge of `from` that shares no vertex with `through` passes through it.
bool an_edge_passes(const Int3& from, const Corners& from_x, const Int3& through, const Corners& through_x) {
  const auto shared = [&](int v) { return v == through.x || v == through.y || v == through.z; };
  for (std::size_t i = 0; i < 3; i++) {
    const std::size_t j = (i + 1) % 3;
    if (!shared(from[int(i)]) && !shared(from[int(j)]) && passes_through(from_x[i], from_x[j], through_x))
      return true;
  }
  return false;
}

int shared_vertices(const Int3& s, const Int3& t) {
  int count = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) count += s[i] == t[j];
  return count;
}

}  // namespace

std::vector<std::pair<int, int>> crossing_triangles(const Exec& exec, const TriMesh& surface) {
  std::vector<Vec3d> vertices;
  for (const Vec3 x : surface.vertices) vertices.push_back(Vec3d(x));
  const TriangleTree tree = build_triangle_tree(std::move(vertices), surface.triangles);
  const auto corners = [&](const Int3& t) {
    return Corners{tree.vertices[std::size_t(t.x)], tree.vertices[std::size_t(t.y)],
                   tree.vertices[std::size_t(t.z)]};
  };
  std::vector<std::vector<int>> partners(tree.triangles.size());
  parallel_for(
      exec, tree.triangles.size(),
      [&](std::size_t i) {
        const Int3 s = tree.triangles[i];
        const Corners x = corners(s);
        visit_meeting(tree.boxes, box_around(x), [&](int other) {
          const Int3 t = tree.triangles[std::size_t(other)];
          if (other <= int(i) || shared_vertices(s, t) >= 2) return false;
          const Corners y = corners(t);
          if (an_edge_passes(s, x, t, y) || an_edge_passes(t, y, s, x)) partners[i].push_back(other);
          return false;
        });
        std::sort(partners[i].begin(), partners[i].end());
      },
      64);
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < partners.size(); i++)
    for (const int other : partners[i]) pairs.emplace_back(int(i), other);
  return pairs;
}

}  // namespace turgor

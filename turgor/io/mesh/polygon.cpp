#include "turgor/io/mesh/polygon.hpp"

#include <numeric>

namespace turgor::io {

namespace {

/// Twice the area times the normal (Newell's method).
Vec3d area_vector(std::span<const Vec3d> corners) {
  Vec3d sum;
  for (std::size_t c = 0; c < corners.size(); c++)
    sum += cross(corners[c] - corners[0], corners[(c + 1) % corners.size()] - corners[0]);
  return sum;
}

/// Twice the signed area of a triangle about the normal.
double area(Vec3d a, Vec3d b, Vec3d c, Vec3d normal) { return dot(cross(b - a, c - a), normal); }

bool is_convex(std::span<const Vec3d> corners, Vec3d normal) {
  const std::size_t count = corners.size();
  for (std::size_t c = 0; c < count; c++)
    if (area(corners[c], corners[(c + 1) % count], corners[(c + 2) % count], normal) < 0) return false;
  return true;
}

/// True if the corner at `at` of the remaining polygon is an ear: it is convex and its triangle holds no
/// other corner.
bool is_ear(std::span<const Vec3d> corners, const std::vector<int>& remaining, std::size_t at, Vec3d normal) {
  const std::size_t count = remaining.size(), before = (at + count - 1) % count, after = (at + 1) % count;
  const auto x = [&](std::size_t i) { return corners[std::size_t(remaining[i])]; };
  const Vec3d a = x(before), b = x(at), c = x(after);
  if (area(a, b, c, normal) <= 0) return false;
  for (std::size_t i = 0; i < count; i++) {
    if (i == before || i == at || i == after) continue;
    if (area(a, b, x(i), normal) >= 0 && area(b, c, x(i), normal) >= 0 && area(c, a, x(i), normal) >= 0)
      return false;
  }
  return true;
}

}  // namespace

std::vector<Int3> triangulate(std::span<const Vec3d> corners) {
  const Vec3d normal = area_vector(corners);
  const bool convex = corners.size() == 3 || is_convex(corners, normal);
  if (!convex && corners.size() > kMostConcaveCorners) return {};
  std::vector<Int3> triangles;
  if (convex) {  // fan
    for (int c = 1; c + 1 < int(corners.size()); c++) triangles.push_back({0, c, c + 1});
    return triangles;
  }
  std::vector<int> remaining(corners.size());
  std::iota(remaining.begin(), remaining.end(), 0);
  while (remaining.size() >= 3) {
    std::size_t ear = 1;
    while (ear <= remaining.size() && !is_ear(corners, remaining, ear % remaining.size(), normal)) ear++;
    if (ear > remaining.size()) ear = 1;  // self-intersecting polygon: any corner is as good
    const std::size_t count = remaining.size(), at = ear % count;
    triangles.push_back({remaining[(at + count - 1) % count], remaining[at], remaining[(at + 1) % count]});
    remaining.erase(remaining.begin() + std::ptrdiff_t(at));
  }
  return triangles;
}

}  // namespace turgor::io

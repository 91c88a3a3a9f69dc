#include "turgor/window/cut_preview.hpp"

#include <algorithm>
#include <array>

namespace turgor {

namespace {

/// Plane of a straight cut with its axes.
struct CutPlane {
  Vec3d from, along, outward, across;  // unit axes
  double length = 0;                   // [m]
};

/// Keeps the part of a piece between both ends of the cut. False: none.
bool clip(const CutPlane& plane, Vec3d& a, Vec3d& b) {
  double s = dot(a - plane.from, plane.along), t = dot(b - plane.from, plane.along);
  if (s > t) std::swap(a, b), std::swap(s, t);
  if (t <= 0 || s >= plane.length || t - s <= 0) return false;
  const Vec3d step = (b - a) * (1 / (t - s));
  const Vec3d begin = a + step * std::max(0.0, -s);
  b = a + step * (std::min(t, plane.length) - s);
  a = begin;
  return true;
}

/// Adds the piece of a triangle in the plane.
void add_piece(const CutPlane& plane, const std::array<Vec3d, 3>& corner, SkinLine& line) {
  // the two crossed edges
  std::array<double, 3> side;
  for (std::size_t c = 0; c < 3; c++) side[c] = dot(corner[c] - plane.from, plane.across);
  std::array<Vec3d, 2> crossing;
  std::size_t count = 0;
  for (std::size_t c = 0; c < 3 && count < 2; c++) {
    const std::size_t next = (c + 1) % 3;
    if ((side[c] > 0) == (side[next] > 0)) continue;
    crossing[count++] = corner[c] + (corner[next] - corner[c]) * (side[c] / (side[c] - side[next]));
  }
  if (count < 2) return;

  // on the side of the body that the cut begins on
  if (dot(cross(corner[1] - corner[0], corner[2] - corner[0]), plane.outward) <= 0) return;
  if (!clip(plane, crossing[0], crossing[1])) return;
  const auto height = [&plane](Vec3d p) { return std::abs(dot(p - plane.from, plane.outward)); };
  if (std::max(height(crossing[0]), height(crossing[1])) > plane.length) return;
  line.pieces.push_back({crossing[0], crossing[1]});
  line.length += norm(crossing[1] - crossing[0]);
}

}  // namespace

SkinLine line_on_skin(std::span<const Vec3> x, std::span<const Int3> triangles, Vec3d from, Vec3d from_normal,
                      Vec3d to, Vec3d to_normal) {
  SkinLine line;
  const double length = norm(to - from);
  const Vec3d normal = from_normal + to_normal, side = cross(to - from, normal);
  if (!(length > 0) || !(norm(side) > 1e-9 * length)) return line;
  const Vec3d along = (to - from) * (1 / length), across = normalized(side);
  const CutPlane plane{from, along, cross(across, along), across, length};
  line.outward = plane.outward;
  for (const Int3 t : triangles)
    add_piece(plane, {Vec3d(x[std::size_t(t.x)]), Vec3d(x[std::size_t(t.y)]), Vec3d(x[std::size_t(t.z)])},
              line);
  return line;
}

}  // namespace turgor

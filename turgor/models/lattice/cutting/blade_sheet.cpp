#include "turgor/models/lattice/cutting/blade_sheet.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::lattice {

void add_triangle(BladeSheet& sheet, const std::array<Vec3d, 3>& corner, const std::array<double, 3>& along) {
  SheetTriangle t{
      .corner = corner[0],
      .side1 = corner[1] - corner[0],
      .side2 = corner[2] - corner[0],
      .normal = {},
      .along = {along[0], along[1], along[2]},
      .box = {min(corner[0], min(corner[1], corner[2])), max(corner[0], max(corner[1], corner[2]))}};
  t.normal = cross(t.side1, t.side2);
  if (!(norm(t.normal) > 0)) return;
  sheet.box = sheet.triangles.empty() ? t.box : joined(sheet.box, t.box);
  sheet.triangles.push_back(t);
}

BladeSheet sweep_blade(const BladePath& path, double tilt, double margin, double epsilon) {
  const std::size_t count = path.points.size();
  TURGOR_CHECK(path.inward.size() == count && path.depths.size() == count && count >= 2,
               "a path has at least two points, each with a direction and a depth");
  TURGOR_CHECK(std::all_of(path.inward.begin(), path.inward.end(), [](Vec3d d) { return is_unit(d); }),
               "directions into the body are unit vectors");
  // rulings of the sheet, one per point of the path
  std::vector<std::array<Vec3d, 3>> rulings(count);  // each: above the skin, on the skin, at the blade's edge
  std::vector<double> along(count);
  for (std::size_t n = 0; n < count; n++) {
    const Vec3d down =
        path.inward[n] + across_at(path, n) * std::tan(tilt);  // displacement per unit of depth
    // extend the sheet at both ends, so that edges through an end are cut
    const double ahead = n == 0 ? -epsilon : n + 1 == count ? epsilon : 0;
    const Vec3d point = path.points[n] - across_at(path, n) * epsilon + tangent_at(path, n) * ahead;
    rulings[n] = {point - down * margin, point, point + down * (path.depths[n] + epsilon)};
    if (n > 0) along[n] = along[n - 1] + norm(path.points[n] - path.points[n - 1]);
  }
  // triangles between neighboring rulings
  BladeSheet sheet;
  for (std::size_t n = 1; n < count; n++)
    for (std::size_t strip = 0; strip < 2; strip++) {  // above and below the skin
      const Vec3d a = rulings[n - 1][strip], b = rulings[n - 1][strip + 1], c = rulings[n][strip],
                  d = rulings[n][strip + 1];
      add_triangle(sheet, {a, b, c}, {along[n - 1], along[n - 1], along[n]});
      add_triangle(sheet, {c, b, d}, {along[n], along[n - 1], along[n]});
    }
  return sheet;
}

void add_strip(BladeSheet& sheet, const std::array<Vec3d, 4>& corner, double along) {
  const auto& [a, b, c, d] = corner;
  add_triangle(sheet, {a, b, c}, {along, along, along});
  add_triangle(sheet, {c, b, d}, {along, along, along});
}

std::optional<SheetCrossing> cross_sheet(const BladeSheet& sheet, std::span<const int> triangles, Vec3d a,
                                         Vec3d b) {
  constexpr double kSlack = 1e-9;  // relative size; a shared side belongs to both triangles
  for (const int index : triangles) {
    const SheetTriangle& t = sheet.triangles[std::size_t(index)];
    const double side_a = dot(t.normal, a - t.corner), side_b = dot(t.normal, b - t.corner);
    if ((side_a >= 0) == (side_b >= 0)) continue;
    const double fraction = side_a / (side_a - side_b), area2 = dot(t.normal, t.normal);
    const Vec3d at = a + (b - a) * fraction - t.corner;
    const double p = dot(cross(at, t.side2), t.normal) / area2, q = dot(cross(t.side1, at), t.normal) / area2;
    if (p < -kSlack || q < -kSlack || p + q > 1 + kSlack) continue;
    return SheetCrossing{fraction, t.along[0] + p * (t.along[1] - t.along[0]) + q * (t.along[2] - t.along[0]),
                         side_b >= 0};
  }
  return {};
}

void triangles_near(const BladeSheet& sheet, const Box& box, std::vector<int>& found) {
  found.clear();
  if (!meet(sheet.box, box)) return;
  for (std::size_t t = 0; t < sheet.triangles.size(); t++)
    if (meet(sheet.triangles[t].box, box)) found.push_back(int(t));
}

}  // namespace turgor::lattice

#include "turgor/models/lattice/cutting/undermine.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/skin_near.hpp"

namespace turgor::lattice {

namespace {

/// Distance between the surface and the crack tips at the ends of the cut, in spacings. The plane that splits
/// a crack tip is fitted to all cuts in and around its cell. Cuts of this surface among them would turn the
/// plane, and the wound would end a cell earlier.
constexpr double kTipCells = 2;

/// Points of the surface on a ruling across the path, from left to right; nothing where there is no skin
/// above.
using Ruling = std::vector<std::optional<Vec3d>>;

/// True if the node nearest to a point is bone.
bool is_in_bone(const Model& model, Vec3d point) {
  const Lattice& l = model.anatomy.lattice;
  const Vec3 h = l.spacing;
  const Int3 node{int(std::lround(point.x / double(h.x))), int(std::lround(point.y / double(h.y))),
                  int(std::lround(point.z / double(h.z))) - l.first};
  return contains(l, node) && model.anatomy.tissue[std::size_t(node_slot(l, node))] == Tissue::kBone;
}

/// Moving average of the heights of one column of rulings along the path, without the steps of the skin.
void smooth_column(std::vector<std::vector<std::optional<double>>>& height, std::size_t column) {
  constexpr std::size_t kReach = 3;
  std::vector<std::optional<double>> smooth(height.size());
  for (std::size_t n = 0; n < height.size(); n++) {
    if (!height[n][column]) continue;
    double sum = 0;
    int count = 0;
    const std::size_t reach = std::min({kReach, n, height.size() - 1 - n});
    for (std::size_t m = n - reach; m <= n + reach; m++)
      if (height[m][column]) sum += *height[m][column], count++;
    smooth[n] = sum / count;
  }
  for (std::size_t n = 0; n < height.size(); n++) height[n][column] = smooth[n];
}

}  // namespace

void add_undermining(const Model& model, const Motion& motion, const BladePath& path,
                     const Undermining& undermine, const HaloExchange* halo, BladeSheet& sheet) {
  TURGOR_CHECK(undermine.width > 0 && undermine.depth > 0, "a surface has a width and a depth");
  const double step = smallest_spacing(model.anatomy.lattice), epsilon = 1e-4 * step;
  const int half = std::max(1, int(std::ceil(undermine.width / (0.5 * step))));
  const auto columns = std::size_t(2 * half + 1);
  const Vec3d shift{0.37 * epsilon, 0.61 * epsilon, 0.71 * epsilon};  // no node lies exactly in the surface
  // points above the surface, and the skin around them
  const auto side_of = [&](std::size_t c) { return (int(c) - half) * undermine.width / half; };
  const auto aside = [&](std::size_t n, std::size_t c) {
    return path.points[n] + across_at(path, n) * side_of(c);
  };
  std::vector<Vec3d> around;
  for (std::size_t n = 0; n < path.points.size(); n++)
    for (const std::size_t c : {std::size_t(0), columns - 1}) around.push_back(aside(n, c));
  // and beyond both ends of the cut, where its crack tips are unless the skin ends
  const auto beyond = [&](std::size_t n) {
    return path.points[n] + tangent_at(path, n) * (n == 0 ? -step : step);
  };
  for (const std::size_t n : {std::size_t(0), path.points.size() - 1}) around.push_back(beyond(n));
  const SkinNow near = skin_near(model, motion, around, halo);
  const auto goes_on = [&](std::size_t n) {
    return distance_to_skin(near, beyond(n), path.inward[n], across_at(path, n) * epsilon).has_value();
  };
  // height of the skin
  std::vector<std::vector<std::optional<double>>> height(path.points.size());
  for (std::size_t n = 0; n < path.points.size(); n++)
    for (std::size_t c = 0; c < columns; c++)
      height[n].push_back(distance_to_skin(near, aside(n, c), path.inward[n], across_at(path, n) * epsilon));
  for (std::size_t c = 0; c < columns; c++) smooth_column(height, c);
  // rulings below it
  std::vector<Ruling> rulings(path.points.size());
  for (std::size_t n = 0; n < rulings.size(); n++) {
    const double ahead = n == 0 ? -epsilon : n + 1 == rulings.size() ? epsilon : 0;  // as sweep_blade
    for (std::size_t c = 0; c < columns; c++) {
      rulings[n].emplace_back();
      if (!height[n][c]) continue;
      const Vec3d point = aside(n, c) + tangent_at(path, n) * ahead +
                          path.inward[n] * (*height[n][c] + std::min(undermine.depth, path.depths[n])) +
                          shift;
      if (!is_in_bone(model, point)) rulings[n].back() = point;
    }
  }
  // quads between rulings, except near the crack tips
  const double length = path_length(path), inset = kTipCells * largest_spacing(model.anatomy.lattice);
  const double first = goes_on(0) ? inset : 0, last = length - (goes_on(path.points.size() - 1) ? inset : 0);
  double along = 0;
  for (std::size_t n = 1; n < rulings.size(); n++) {
    const double next = along + norm(path.points[n] - path.points[n - 1]);
    const bool is_at_end = along < first || next > last;
    for (std::size_t c = 1; c < columns; c++) {
      const double aside_of_path = std::min(std::abs(side_of(c - 1)), std::abs(side_of(c)));
      if (is_at_end && aside_of_path < inset) continue;
      const auto &a = rulings[n - 1][c - 1], &b = rulings[n - 1][c], &d = rulings[n][c - 1],
                 &e = rulings[n][c];
      if (!a || !b || !d || !e) continue;
      add_triangle(sheet, {*a, *d, *b}, {along, next, along});
      add_triangle(sheet, {*b, *d, *e}, {along, next, next});
    }
    along = next;
  }
}

}  // namespace turgor::lattice

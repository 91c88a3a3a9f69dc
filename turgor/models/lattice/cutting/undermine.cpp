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

/// Beginning of a ruling of the surface, on the path.
struct RulingBase {
  Vec3d point, inward, across;  // `across` points to the right of the path; out of the piece of an excision
  Vec3d ahead;                  // shift of the surface along the path, as sweep_blade shifts its ends
  double along = 0;             // arc length on the path [m]
  double most = 0;              // depth of the blade there [m]
};
/// Points of the surface on a ruling, from left to right; nothing where there is no skin above.
using Ruling = std::vector<std::optional<Vec3d>>;

/// A base at every point of the path. The outline of an excision is closed; where it turns by more than
/// kMostTurn, as at the ends of a lens, bases between fan out.
std::vector<RulingBase> bases_of(const BladePath& path, double epsilon) {
  constexpr double kMostTurn = 0.15;  // [radians]
  std::vector<RulingBase> bases;
  const std::size_t last = path.points.size() - 1;
  double along = 0;
  for (std::size_t n = 0; n <= last; n++) {
    if (n > 0) along += norm(path.points[n] - path.points[n - 1]);
    const Vec3d inward = path.inward[n];
    const auto add = [&](Vec3d across, Vec3d ahead = {}) {
      bases.push_back({.point = path.points[n],
                       .inward = inward,
                       .across = across,
                       .ahead = ahead,
                       .along = along,
                       .most = path.depths[n]});
    };
    if (!path.is_excision) {
      add(across_at(path, n), tangent_at(path, n) * (n == 0 ? -epsilon : n == last ? epsilon : 0));
      continue;
    }
    const auto across_of = [&](std::size_t from) {  // of the segment that begins there
      return normalized(cross(inward, path.points[from + 1] - path.points[from]));
    };
    const Vec3d before = across_of(n == 0 ? last - 1 : n - 1), after = across_of(n == last ? 0 : n);
    const double turn = std::acos(std::clamp(dot(before, after), -1.0, 1.0));
    const int count = int(std::ceil(turn / kMostTurn));
    for (int turned = 0; turned <= count; turned++)
      if (count > 1)
        add(normalized(before * (1 - double(turned) / count) + after * (double(turned) / count)));
    if (count <= 1) add(normalized(before + after));
  }
  return bases;
}

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
  const int left = path.is_excision ? 0 : half;  // columns to the left of the path
  const auto columns = std::size_t(left + half + 1);
  const Vec3d shift{0.37 * epsilon, 0.61 * epsilon, 0.71 * epsilon};  // no node lies exactly in the surface
  // points above the surface, and the skin around them
  const std::vector<RulingBase> bases = bases_of(path, epsilon);
  const auto side_of = [&](std::size_t c) { return (int(c) - left) * undermine.width / half; };
  const auto aside = [&](const RulingBase& base, std::size_t c) {
    return base.point + base.across * side_of(c);
  };
  std::vector<Vec3d> around;
  for (const RulingBase& base : bases)
    for (const std::size_t c : {std::size_t(0), columns - 1}) around.push_back(aside(base, c));
  // and beyond both ends of a cut, where its crack tips are unless the skin ends
  const auto beyond = [&](std::size_t n) {
    return path.points[n] + tangent_at(path, n) * (n == 0 ? -step : step);
  };
  for (const std::size_t n : {std::size_t(0), path.points.size() - 1}) around.push_back(beyond(n));
  const SkinNow near = skin_near(model, motion, around, halo);
  const auto has_crack_tip = [&](std::size_t n) {
    return !path.is_excision &&
           distance_to_skin(near, beyond(n), path.inward[n], across_at(path, n) * epsilon).has_value();
  };
  // height of the skin
  std::vector<std::vector<std::optional<double>>> height(bases.size());
  for (std::size_t n = 0; n < bases.size(); n++)
    for (std::size_t c = 0; c < columns; c++)
      height[n].push_back(
          distance_to_skin(near, aside(bases[n], c), bases[n].inward, bases[n].across * epsilon));
  for (std::size_t c = 0; c < columns; c++) smooth_column(height, c);
  // rulings below it
  std::vector<Ruling> rulings(bases.size());
  for (std::size_t n = 0; n < rulings.size(); n++)
    for (std::size_t c = 0; c < columns; c++) {
      rulings[n].emplace_back();
      if (!height[n][c]) continue;
      const Vec3d point = aside(bases[n], c) + bases[n].ahead +
                          bases[n].inward * (*height[n][c] + std::min(undermine.depth, bases[n].most)) +
                          shift;
      if (!is_in_bone(model, point)) rulings[n].back() = point;
    }
  // quads between rulings, except near the crack tips
  const double length = path_length(path), inset = kTipCells * largest_spacing(model.anatomy.lattice);
  const double first = has_crack_tip(0) ? inset : 0,
               last = length - (has_crack_tip(path.points.size() - 1) ? inset : 0);
  for (std::size_t n = 1; n < rulings.size(); n++) {
    const double along = bases[n - 1].along, next = bases[n].along;
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
  }
}

}  // namespace turgor::lattice

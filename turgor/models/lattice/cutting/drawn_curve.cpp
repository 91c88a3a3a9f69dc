#include "turgor/models/lattice/cutting/drawn_curve.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

namespace {

/// Centripetal Catmull–Rom spline through some points, sampled about every `step`. Two points make a straight
/// line. Equal first and last points close the curve. [Catmull and Rom 1974; Yuksel, Schaefer and Keyser
/// 2011]
std::vector<Vec3d> curve_through(const std::vector<Vec3d>& points, double step) {
  const auto count = points.size();
  TURGOR_ASSERT(count >= 2 && step > 0, "a curve has at least two points and a sample spacing");
  const bool closed = count > 3 && norm(points.front() - points.back()) < 1e-9;
  // control points, wrapped or reflected at the ends
  const auto at = [&](std::ptrdiff_t n) {
    const auto last = std::ptrdiff_t(count) - 1;
    if (n < 0) return closed ? points[std::size_t(last + n)] : points[0] * 2.0 - points[1];
    if (n > last) return closed ? points[std::size_t(n - last)] : points[count - 1] * 2.0 - points[count - 2];
    return points[std::size_t(n)];
  };
  std::vector<Vec3d> curve{points[0]};
  for (std::size_t n = 0; n + 1 < count; n++) {
    const auto m = std::ptrdiff_t(n);
    const Vec3d p0 = at(m - 1), p1 = at(m), p2 = at(m + 1), p3 = at(m + 2);
    // knots, spaced by the square root of the chord length
    const double t1 = std::sqrt(norm(p1 - p0)), t2 = t1 + std::sqrt(norm(p2 - p1)),
                 t3 = t2 + std::sqrt(norm(p3 - p2));
    const auto between = [](Vec3d a, Vec3d b, double ta, double tb, double t) {
      return tb > ta ? a * ((tb - t) / (tb - ta)) + b * ((t - ta) / (tb - ta)) : b;
    };
    // Barry–Goldman evaluation
    const int segments = std::max(1, int(std::ceil(norm(p2 - p1) / step)));
    for (int segment = 1; segment <= segments; segment++) {
      const double t = t1 + (t2 - t1) * segment / segments;
      const Vec3d a = between(p0, p1, 0, t1, t), b = between(p1, p2, t1, t2, t),
                  c = between(p2, p3, t2, t3, t);
      curve.push_back(between(between(a, b, 0, t2, t), between(b, c, t1, t3, t), t1, t2, t));
    }
  }
  return curve;
}

double fine_spacing(const FineLattice& f) {
  return smallest_spacing(f.cells) / std::max({f.subdivisions.x, f.subdivisions.y, f.subdivisions.z});
}

/// Arc length on a laid blade's path of a point drawn on its curve [m]. Empty if the point is not on the
/// curve.
std::optional<double> arc_length_on(const Model& model, const LaidBlade& blade, Vec3d point) {
  constexpr double kRounding = 1e-3;  // largest distance of the point from the curve [cells]
  const std::vector<Vec3d> curve = drawn_curve(model, blade.drawn);
  if (curve.size() != blade.path.points.size()) return {};  // restored from a recording, without its cuts
  double along = 0;
  for (std::size_t n = 0; n + 1 < curve.size(); n++) {
    const Vec3d direction = curve[n + 1] - curve[n];
    const double fraction =
        std::clamp(dot(point - curve[n], direction) / dot(direction, direction), 0.0, 1.0);
    const double length = norm(blade.path.points[n + 1] - blade.path.points[n]);
    if (norm(point - curve[n] - direction * fraction) <= kRounding * smallest_spacing(model.anatomy.lattice))
      return along + length * fraction;
    along += length;
  }
  return {};
}

/// Current position of a cut point: mean over the fragments at both ends of the cut edge [m].
Vec3d current_position(const Model& model, const State& state, const Fragments& fragments,
                       const CutEdge& edge, Vec3d rest) {
  TURGOR_CHECK(is_index(edge.family, kFamilyCount), "a cut edge belongs to one of the seven families");
  const FineLattice& f = fragments.fine;
  // trilinear weights in the cell
  const Int3 local = fine_node(f, edge) - first_of_cell(f, slot_node(f.cells, edge.slot));
  const Vec3d at = Vec3d(local) + Vec3d(kFamilies[edge.family]) * double(edge.fraction);
  const auto weight =
      trilinear(Vec3d{at.x / f.subdivisions.x, at.y / f.subdivisions.y, at.z / f.subdivisions.z});
  const CutCell* cut = find_cell(fragments, edge.slot);
  // mean over the fragments of both ends
  Vec3d sum = rest;
  for (const Int3 end : {local, local + kFamilies[edge.family]}) {
    const int fragment =
        cut && in_cell(f, end) ? fragment_of(fragments.label.data(), *cut, sub_index(f, end)) : -1;
    const auto corners = corners_of(model, fragments, edge.slot, fragment);
    for (std::size_t c = 0; c < 8; c++)
      sum += Vec3d(corner_displacement(model, state, fragments, corners[c])) * (weight[c] / 2);
  }
  return sum;
}

/// Cut fine edge of an earlier incision near one arc length of its path. `depth` is below the skin, `beyond`
/// is the arc length past that position [m].
struct JunctionSample {
  double depth, beyond;
  Vec3d now;  // current position [m]
};
std::vector<JunctionSample> sample_earlier_cut(const Model& model, const State& state,
                                               const Fragments& fragments, const LaidBlade& blade,
                                               double along, const HaloExchange* halo) {
  const FineLattice& f = fragments.fine;
  const double reach = fine_spacing(f);
  const PathPosition position = position_along(blade.path, along);
  const std::size_t n = position.segment + (position.fraction > 0.5 ? 1 : 0);
  std::vector<std::pair<std::uint64_t, JunctionSample>>
      found;  // keyed by edge; sorted, so that sums do not depend on the order of cutting
  // cut fine edges near that arc length, in layers owned by this process
  for (const CutEdge& edge : blade.path.fine_edges) {
    const int layer = slot_node(f.cells, edge.slot).z;
    if (layer < model.anatomy.owned.begin || layer >= model.anatomy.owned.end) continue;
    if (std::abs(double(edge.along) - along) > reach) continue;
    const Int3 a = fine_node(f, edge);
    const Vec3d direction = lattice_index(f, a + kFamilies[edge.family]) - lattice_index(f, a);
    const Vec3d rest =
        hadamard(lattice_index(f, a) + direction * double(edge.fraction), Vec3d(f.cells.spacing));
    found.push_back({fine_edge_key(f, a, edge.family),
                     {dot(rest - blade.path.points[n], blade.path.inward[n]), double(edge.along) - along,
                      current_position(model, state, fragments, edge, rest)}});
  }
  // samples of all processes, in the order of edges
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> numbers;
  for (const auto& [key, at] : found)
    numbers.insert(numbers.end(), {at.depth, at.beyond, at.now.x, at.now.y, at.now.z});
  if (halo) halo->join_numbers(numbers);
  std::vector<JunctionSample> samples;
  TURGOR_CHECK(numbers.size() % 5 == 0, "a sample of a cut has five numbers");
  for (std::size_t i = 0; i + 4 < numbers.size(); i += 5)
    samples.push_back({numbers[i], numbers[i + 1], {numbers[i + 2], numbers[i + 3], numbers[i + 4]}});
  return samples;
}

/// Junction line through samples of a cut, from above the skin downwards. Empty without samples at the skin.
JunctionLine line_through(const std::vector<JunctionSample>& samples, const LaidBlade& blade, std::size_t n,
                          double step) {
  const Vec3d into = blade.path.inward[n], across = across_at(blade.path, n);
  const Vec3d down = into + across * std::tan(blade.drawn.tilt * std::numbers::pi / 180);
  // mean of samples near a depth, shifted to that depth
  const auto mean_near = [&](double depth) -> std::optional<Vec3d> {
    Vec3d sum;
    int count = 0;
    for (const JunctionSample& at : samples)
      if (std::abs(at.depth - depth) <= step) sum += at.now - down * (at.depth - depth), count++;
    if (count == 0) return {};
    return sum / double(count);
  };
  JunctionLine line{.step = step, .points = {}};
  double beyond = 0;  // sum over the samples at the skin
  int count = 0;
  for (const JunctionSample& at : samples)
    if (std::abs(at.depth) <= step) beyond += at.beyond, count++;
  int missing = 0;  // depths without samples, below the body: the line is extended by at most three points
  // points from the skin down
  for (int k = 0; k * step <= blade.path.depth + step && missing < 3; k++) {
    const std::optional<Vec3d> point = mean_near(k * step);
    if (!point && line.points.empty()) return line;
    missing += !point;
    line.points.push_back(point ? *point : line.points.back() + down * step);
  }
  // end of the new curve on the skin, shifted back by the mean of `beyond`
  if (!line.points.empty())
    line.end = line.points.front() - tangent_at(blade.path, n) * (beyond / std::max(count, 1));
  // points above the skin
  for (int k = 1; k <= JunctionLine::kAbove && !line.points.empty(); k++)
    line.points.insert(line.points.begin(), mean_near(-k * step).value_or(line.points.front() - down * step));
  return line;
}

/// Moves the first point of a curve by `shift`. The shift of the next points decays linearly with arc length.
void bend_start(std::vector<Vec3d>& curve, Vec3d shift) {
  constexpr double kBendLength = 4;  // length of the bend, in lengths of the shift
  TURGOR_ASSERT(!curve.empty(), "a curve has a start");
  double along = 0;
  Vec3d before = curve[0];
  for (Vec3d& point : curve) {
    along += norm(point - before);
    before = point;
    const double weight_left = 1 - along / (kBendLength * norm(shift));
    if (!(weight_left > 0) || &point == &curve.back()) return;
    point += shift * weight_left;
  }
}

}  // namespace

std::vector<Vec3d> drawn_points(const Model& model, const Incision& incision) {
  const Mat3d to_lattice = inverse(model.anatomy.grid.axes);
  std::vector<Vec3d> points;
  for (const Vec3d p : incision.path) points.push_back(to_lattice * (p - model.anatomy.grid.origin));
  if (points.size() < 2)
    points = {to_lattice * (incision.from - model.anatomy.grid.origin),
              to_lattice * (incision.to - model.anatomy.grid.origin)};
  return points;
}

std::vector<Vec3d> drawn_curve(const Model& model, const Incision& incision) {
  return curve_through(drawn_points(model, incision), 0.5 * smallest_spacing(model.anatomy.lattice));
}

std::array<JunctionLine, 2> join_laid_blades(const Model& model, const State& state,
                                             std::span<const LaidBlade> laid, const HaloExchange* halo,
                                             std::vector<Vec3d>& curve) {
  std::shared_ptr<const Fragments> fragments;
  std::array<JunctionLine, 2> met;
  // both ends: the start, then the start of the reversed curve
  for (JunctionLine& line : met) {
    for (const LaidBlade& blade : laid) {
      const std::optional<double> along = arc_length_on(model, blade, curve[0]);
      if (!along) continue;
      if (!fragments) fragments = fragments_of(model, state.cuts);
      // first laid blade with this end on its curve
      const std::size_t n = position_along(blade.path, *along).segment;
      line = line_through(sample_earlier_cut(model, state, *fragments, blade, *along, halo), blade, n,
                          fine_spacing(fragments->fine));
      if (line.points.empty()) continue;
      bend_start(curve, line.end - curve[0]);
      break;
    }
    std::reverse(curve.begin(), curve.end());
  }
  return met;
}

void join_sheet(const BladePath& path, const std::array<JunctionLine, 2>& met, double tilt,
                BladeSheet& sheet) {
  constexpr double kOvershoot = 0.15;  // reach past the earlier cut [fine cells]
  for (const bool last : {false, true}) {
    const JunctionLine& line = met[std::size_t(last)];
    if (line.points.empty()) continue;
    const std::size_t n = last ? path.points.size() - 1 : 0;
    // direction down the blade, and overshoot past the earlier cut
    const Vec3d down = path.inward[n] + across_at(path, n) * std::tan(tilt),
                beyond = tangent_at(path, n) * (kOvershoot * line.step * (last ? 1 : -1));
    const double along = last ? path_length(path) : 0;
    Vec3d own_before, met_before;
    // strips between the path's end line and the junction line
    for (std::size_t k = 0; k < line.points.size(); k++) {
      if (path.depths[n] < path.depth && (double(k) - JunctionLine::kAbove) * line.step > path.depths[n])
        break;  // at bone
      const Vec3d own = path.points[n] + down * ((double(k) - JunctionLine::kAbove) * line.step),
                  met_point = line.points[k] + beyond;
      if (k > 0 && last) add_strip(sheet, {own_before, own, met_before, met_point}, along);
      if (k > 0 && !last) add_strip(sheet, {met_before, met_point, own_before, own}, along);
      own_before = own, met_before = met_point;
    }
  }
}

}  // namespace turgor::lattice

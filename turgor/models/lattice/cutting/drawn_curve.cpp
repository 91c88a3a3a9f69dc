#include "turgor/models/lattice/cutting/drawn_curve.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

namespace {

/// A smooth curve through some points, as points about `step` apart; two make a straight line. The same first
/// and last point close it. [centripetal: Catmull and Rom 1974; Yuksel, Schaefer and Keyser 2011]
std::vector<Vec3d> curve_through(const std::vector<Vec3d>& points, double step) {
  const auto count = points.size();
  const bool closed = count > 3 && norm(points.front() - points.back()) < 1e-9;
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
    const double t1 = std::sqrt(norm(p1 - p0)), t2 = t1 + std::sqrt(norm(p2 - p1)),
                 t3 = t2 + std::sqrt(norm(p3 - p2));
    const auto between = [](Vec3d a, Vec3d b, double ta, double tb, double t) {
      return tb > ta ? a * ((tb - t) / (tb - ta)) + b * ((t - ta) / (tb - ta)) : b;
    };
    const int parts = std::max(1, int(std::ceil(norm(p2 - p1) / step)));
    for (int part = 1; part <= parts; part++) {
      const double t = t1 + (t2 - t1) * part / parts;
      const Vec3d a = between(p0, p1, 0, t1, t), b = between(p1, p2, t1, t2, t),
                  c = between(p2, p3, t2, t3, t);
      curve.push_back(between(between(a, b, 0, t2, t), between(b, c, t1, t3, t), t1, t2, t));
    }
  }
  return curve;
}

double fine_step(const FineLattice& f) {
  return smallest_step(f.cells) / std::max({f.parts.x, f.parts.y, f.parts.z});
}

/// How far along a laid blade's path a point was drawn on it [m]; nothing where it was not.
std::optional<double> drawn_along(const Model& model, const LaidBlade& blade, Vec3d point) {
  constexpr double kRounding = 1e-3;  // of a step
  const std::vector<Vec3d> curve = drawn_curve(model, blade.drawn);
  if (curve.size() != blade.path.skin.size()) return {};  // read back, without what it cut
  double along = 0;
  for (std::size_t n = 0; n + 1 < curve.size(); n++) {
    const Vec3d way = curve[n + 1] - curve[n];
    const double part = std::clamp(dot(point - curve[n], way) / dot(way, way), 0.0, 1.0);
    const double length = norm(blade.path.skin[n + 1] - blade.path.skin[n]);
    if (norm(point - curve[n] - way * part) <= kRounding * smallest_step(model.lattice))
      return along + length * part;
    along += length;
  }
  return {};
}

/// Where the tissue at a place on a cut edge is: between its two sides, as the edge was cut [m].
Vec3d place_now(const Model& model, const State& state, const Fragments& pieces, const CutEdge& edge,
                Vec3d rest) {
  const FineLattice& f = pieces.fine;
  const Int3 local = fine_node(f, edge) - first_of_cell(f, slot_node(f.cells, edge.slot));
  const Vec3d at = Vec3d(local) + Vec3d(kFamilies[edge.family]) * double(edge.fraction);
  const auto weight = trilinear(Vec3d{at.x / f.parts.x, at.y / f.parts.y, at.z / f.parts.z});
  const CutCell* cut = find_cell(pieces, edge.slot);
  Vec3d sum = rest;
  for (const Int3 end : {local, local + kFamilies[edge.family]}) {
    const int piece =
        cut && in_cell(f, end) ? piece_of(pieces.label.data(), *cut, place_in_cell(f, end)) : -1;
    const auto corners = corners_of(model, pieces, edge.slot, piece);
    for (std::size_t c = 0; c < 8; c++)
      sum += Vec3d(corner_displacement(model, state, pieces, corners[c])) * (weight[c] / 2);
  }
  return sum;
}

/// What a laid blade cuts in the tissue near one place of its path: how deep below the skin, how far beyond
/// that place, and where now.
struct CutPlace {
  double depth, beyond;
  Vec3d now;  // [m]
};
std::vector<CutPlace> places_cut(const Model& model, const State& state, const Fragments& pieces,
                                 const LaidBlade& blade, double along, const HaloExchange* halo) {
  const FineLattice& f = pieces.fine;
  const double reach = fine_step(f);
  const PathPlace place = place_along(blade.path, along);
  const std::size_t n = place.n + (place.rest > 0.5 ? 1 : 0);
  std::vector<std::pair<std::uint64_t, CutPlace>> found;  // by edge, so that every order gives the same sums
  for (const CutEdge& edge : blade.path.fine_edges) {
    const int layer = slot_node(f.cells, edge.slot).z;
    if (layer < model.owned.begin || layer >= model.owned.end) continue;
    if (std::abs(double(edge.along) - along) > reach) continue;
    const Int3 a = fine_node(f, edge);
    const Vec3d way = lattice_index(f, a + kFamilies[edge.family]) - lattice_index(f, a);
    const Vec3d rest = hadamard(lattice_index(f, a) + way * double(edge.fraction), Vec3d(f.cells.step));
    found.push_back({fine_edge_key(f, a, edge.family),
                     {dot(rest - blade.path.skin[n], blade.path.into[n]), double(edge.along) - along,
                      place_now(model, state, pieces, edge, rest)}});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> numbers;
  for (const auto& [key, at] : found)
    numbers.insert(numbers.end(), {at.depth, at.beyond, at.now.x, at.now.y, at.now.z});
  if (halo) halo->join_numbers(numbers);
  std::vector<CutPlace> places;
  for (std::size_t i = 0; i + 4 < numbers.size(); i += 5)
    places.push_back({numbers[i], numbers[i + 1], {numbers[i + 2], numbers[i + 3], numbers[i + 4]}});
  return places;
}

/// The line that a cut draws from above the skin downwards, now. Empty where nothing is cut at the skin.
MetLine line_through(const std::vector<CutPlace>& places, const LaidBlade& blade, std::size_t n,
                     double step) {
  const Vec3d into = blade.path.into[n], across = across_at(blade.path, n);
  const Vec3d down = into + across * std::tan(blade.drawn.tilt * std::numbers::pi / 180);
  const auto mean_near = [&](double depth) -> std::optional<Vec3d> {
    Vec3d sum;
    int count = 0;
    for (const CutPlace& at : places)
      if (std::abs(at.depth - depth) <= step) sum += at.now - down * (at.depth - depth), count++;
    if (count == 0) return {};
    return sum / double(count);
  };
  MetLine line{.step = step, .places = {}};
  double beyond = 0;  // the mean at the skin
  int count = 0;
  for (const CutPlace& at : places)
    if (std::abs(at.depth) <= step) beyond += at.beyond, count++;
  int missing = 0;  // where the body ends, a little further
  for (int k = 0; k * step <= blade.path.depth + step && missing < 3; k++) {
    const std::optional<Vec3d> place = mean_near(k * step);
    if (!place && line.places.empty()) return line;
    missing += !place;
    line.places.push_back(place ? *place : line.places.back() + down * step);
  }
  if (!line.places.empty())
    line.end = line.places.front() - line_at(blade.path, n) * (beyond / std::max(count, 1));
  for (int k = 1; k <= MetLine::kAbove && !line.places.empty(); k++)
    line.places.insert(line.places.begin(), mean_near(-k * step).value_or(line.places.front() - down * step));
  return line;
}

/// Moves the first point of a curve by `shift`, and what is beside it by less and less.
void bend_start(std::vector<Vec3d>& curve, Vec3d shift) {
  constexpr double kReach = 4;  // times the shift
  double along = 0;
  Vec3d before = curve[0];
  for (Vec3d& point : curve) {
    along += norm(point - before);
    before = point;
    const double left = 1 - along / (kReach * norm(shift));
    if (!(left > 0) || &point == &curve.back()) return;
    point += shift * left;
  }
}

}  // namespace

std::vector<Vec3d> drawn_points(const Model& model, const Incision& incision) {
  const Mat3d to_lattice = inverse(model.grid.axes);
  std::vector<Vec3d> points;
  for (const Vec3d p : incision.path) points.push_back(to_lattice * (p - model.grid.origin));
  if (points.size() < 2)
    points = {to_lattice * (incision.from - model.grid.origin),
              to_lattice * (incision.to - model.grid.origin)};
  return points;
}

std::vector<Vec3d> drawn_curve(const Model& model, const Incision& incision) {
  return curve_through(drawn_points(model, incision), 0.5 * smallest_step(model.lattice));
}

std::array<MetLine, 2> meet_laid_blades(const Model& model, const State& state,
                                        std::span<const LaidBlade> laid, const HaloExchange* halo,
                                        std::vector<Vec3d>& curve) {
  std::optional<Fragments> pieces;
  std::array<MetLine, 2> met;
  for (MetLine& line : met) {
    for (const LaidBlade& blade : laid) {
      const std::optional<double> along = drawn_along(model, blade, curve[0]);
      if (!along) continue;
      if (!pieces) pieces = make_fragments(model, state);
      const std::size_t n = place_along(blade.path, *along).n;
      line = line_through(places_cut(model, state, *pieces, blade, *along, halo), blade, n,
                          fine_step(pieces->fine));
      if (line.places.empty()) continue;
      bend_start(curve, line.end - curve[0]);
      break;
    }
    std::reverse(curve.begin(), curve.end());
  }
  return met;
}

void join_sheet(const BladePath& path, const std::array<MetLine, 2>& met, double tilt, BladeSheet& sheet) {
  constexpr double kBeyond = 0.15;  // of a fine step
  for (const bool last : {false, true}) {
    const MetLine& line = met[std::size_t(last)];
    if (line.places.empty()) continue;
    const std::size_t n = last ? path.skin.size() - 1 : 0;
    const Vec3d down = path.into[n] + across_at(path, n) * std::tan(tilt),
                beyond = line_at(path, n) * (kBeyond * line.step * (last ? 1 : -1));
    const double along = last ? path_length(path) : 0;
    Vec3d own_before, met_before;
    for (std::size_t k = 0; k < line.places.size(); k++) {
      const Vec3d own = path.skin[n] + down * ((double(k) - MetLine::kAbove) * line.step),
                  there = line.places[k] + beyond;
      if (k > 0 && last) add_strip(sheet, {own_before, own, met_before, there}, along);
      if (k > 0 && !last) add_strip(sheet, {met_before, there, own_before, own}, along);
      own_before = own, met_before = there;
    }
  }
}

}  // namespace turgor::lattice

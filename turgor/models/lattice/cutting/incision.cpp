#include "turgor/models/lattice/cutting/incision.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include "turgor/geometry/where_is.hpp"
#include "turgor/models/lattice/build/skin.hpp"
#include "turgor/models/lattice/cutting/blade_sheet.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"
#include "turgor/models/lattice/key_index.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

namespace {

constexpr double kReach = 0.1;  // how far from the given line the skin may be [m]

Vec3d skin_corner(const Model& model, const State& state, const SkinTriangle& t, int corner) {
  return Vec3d(position(model, state, slot_node(model.lattice, t.vertex[corner])));
}

double largest_step(const Lattice& l) { return std::max({l.step.x, l.step.y, l.step.z}); }
/// So far around a point skin has a say in which way is into the body [m].
double reach_of_directions(const Lattice& l) { return std::max(0.01, 3 * largest_step(l)); }

/// Into the body: against the mean normal of the skin around the point of it that is nearest to `point`, at
/// right angles to `line`.
Vec3d direction_into(const SkinNow& skin, Vec3d point, Vec3d line, double around) {
  double nearest = std::numeric_limits<double>::max();
  Vec3d center;
  for (const auto& corner : skin)
    if (norm(corner[0] - point) < nearest) nearest = norm(corner[0] - point), center = corner[0];
  Vec3d normal;
  for (const auto& [a, b, c] : skin)
    if (!(norm(a - center) > around)) normal += cross(b - a, c - a);
  return normalized(line * dot(normal, line) - normal);
}

/// How far along `direction` from `origin` a line meets a triangle; NaN when it does not. [Möller, Trumbore
/// 1997]
double meet(Vec3d origin, Vec3d direction, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d e1 = b - a, e2 = c - a, p = cross(direction, e2);
  const double det = dot(e1, p);
  if (det == 0) return std::numeric_limits<double>::quiet_NaN();
  const Vec3d s = origin - a, q = cross(s, e1);
  const double u = dot(s, p) / det, v = dot(direction, q) / det;
  constexpr double kSlack = 1e-9;  // of the triangle: a line through an edge meets both sides of it
  const bool inside = u >= -kSlack && v >= -kSlack && u + v <= 1 + kSlack;
  return inside ? dot(e2, q) / det : std::numeric_limits<double>::quiet_NaN();
}

/// The skin's corners, patient frame [m].
std::vector<Vec3d> skin_points(const Model& model, const State& state) {
  std::vector<Vec3d> points;
  for (const SkinTriangle& t : model.skin.triangles)
    for (int corner = 0; corner < 3; corner++)
      points.push_back(model.grid.origin + model.grid.axes * skin_corner(model, state, t, corner));
  return points;
}

std::string off_skin(const Model& model, const State& state, const std::string& place, Vec3d point) {
  const Vec3d patient = model.grid.origin + model.grid.axes * point;
  return place + "no skin within " + number_text(kReach) + " m of " + place_text(patient) +
         ": expected a line on the skin; " + where_is(skin_points(model, state), patient);
}

Vec3d tangent(const std::vector<Vec3d>& points, std::size_t n) {
  return normalized(points[std::min(n + 1, points.size() - 1)] - points[n > 0 ? n - 1 : 0]);
}

/// Into the body at every point of a curve: found every centimetre, blended between; one for a straight line.
std::vector<Vec3d> directions_into(const Lattice& lattice, const SkinNow& skin,
                                   const std::vector<Vec3d>& curve, bool straight) {
  constexpr double kApart = 0.01;
  const double around = reach_of_directions(lattice);
  std::vector<Vec3d> into(curve.size());
  if (straight) {
    const Vec3d line = normalized(curve.back() - curve.front()),
                middle = (curve.front() + curve.back()) * 0.5;
    std::fill(into.begin(), into.end(), direction_into(skin, middle, line, around));
    return into;
  }
  const double spacing = norm(curve[1] - curve[0]);
  const auto stride = std::size_t(std::max(1.0, kApart / std::max(spacing, 1e-6)));
  for (std::size_t n = 0; n < curve.size(); n += stride) {
    const std::size_t next = std::min(n + stride, curve.size() - 1);
    const Vec3d a = n > 0 ? into[n] : direction_into(skin, curve[n], tangent(curve, n), around);
    const Vec3d b = direction_into(skin, curve[next], tangent(curve, next), around);
    for (std::size_t m = n; m <= next; m++)
      into[m] = normalized(a + (b - a) * (next > n ? double(m - n) / double(next - n) : 0));
  }
  for (std::size_t n = 0; n < curve.size(); n++) {
    const Vec3d line = tangent(curve, n);
    into[n] = normalized(into[n] - line * dot(into[n], line));
  }
  return into;
}

/// The stairs of the lattice's skin are none of the blade's: mean over a step and a half to both sides.
std::vector<double> without_stairs(const std::vector<double>& offset) {
  constexpr std::size_t kReachPoints = 3;
  std::vector<double> smooth(offset.size());
  for (std::size_t n = 0; n < offset.size(); n++) {
    const std::size_t reach = std::min({kReachPoints, n, offset.size() - 1 - n});
    for (std::size_t m = n - reach; m <= n + reach; m++) smooth[n] += offset[m] / double(2 * reach + 1);
  }
  return smooth;
}

/// The skin within reach of what is asked of it: where the blade meets it, and which way it faces around
/// there.
SkinNow skin_near(const Model& model, const State& state, const std::vector<Vec3d>& curve,
                  const HaloExchange* halo) {
  Box box = box_around(curve);
  const double reach = kReach + reach_of_directions(model.lattice) + 3 * largest_step(model.lattice);
  box.low -= Vec3d{reach, reach, reach}, box.high += Vec3d{reach, reach, reach};
  SkinNow near;
  for (const SkinTriangle& t : skin_of_cells(model, model.owned))
    if (const Vec3d a = skin_corner(model, state, t, 0); squared_distance(box, a) == 0)
      near.push_back({a, skin_corner(model, state, t, 1), skin_corner(model, state, t, 2)});
  if (halo) halo->join_skin(near);
  return near;
}

/// How far along `into` the skin nearest to a point is. A hair's breadth beside it, so that no line runs
/// through the corners of a regular lattice: on the other side where the body ends.
std::optional<double> way_to_skin(const SkinNow& skin, Vec3d point, Vec3d into, Vec3d hair) {
  for (const Vec3d origin : {point - hair, point + hair}) {
    std::optional<double> best;
    for (const auto& [a, b, c] : skin)
      if (const double t = meet(origin, into, a, b, c); std::abs(t) < std::abs(best.value_or(kReach)))
        best = t;
    if (best) return best;
  }
  return {};
}

void cut_edge(const Model& model, State& state, int slot, int family) {
  state.cut[std::size_t(slot)] |= std::uint8_t(1u << family);
  mark_rows(model, state, slot);
}

/// The fine edges that the blade comes by, unless another blade was there before.
void cut_fine_edges(const Model& model, State& state, const BladePath& path, double begin, double end,
                    int incision) {
  const FineLattice f = fine_lattice(model);
  KeyIndex known;
  const auto key = [&](const CutEdge& e) { return fine_edge_key(f, fine_node(f, e), e.family); };
  for (const CutEdge& edge : state.cut_edges) known.find_or_add(key(edge));
  for (CutEdge edge : path.fine_edges) {
    if (double(edge.along) < begin || double(edge.along) >= end || known.find(key(edge)) >= 0) continue;
    edge.incision = std::uint8_t(incision);
    state.cut_edges.push_back(edge);
  }
}

/// Skin on a path of one region's width.
struct Place {
  double along, aside, under;  // from the start of the cut, from its line, below the skin [m]
};
Place place_on(const BladePath& path, Vec3d point) {
  std::size_t nearest = 0;
  for (std::size_t n = 0; n < path.skin.size(); n++)
    if (norm(cross(point - path.skin[n], path.into[n])) <
        norm(cross(point - path.skin[nearest], path.into[nearest])))
      nearest = n;
  const Vec3d away = point - path.skin[nearest];
  double along = dot(away, line_at(path, nearest));
  for (std::size_t n = 0; n < nearest; n++) along += norm(path.skin[n + 1] - path.skin[n]);
  return {along, dot(away, across_at(path, nearest)), dot(away, path.into[nearest])};
}

}  // namespace

double path_length(const BladePath& path) {
  double length = 0;
  for (std::size_t n = 1; n < path.skin.size(); n++) length += norm(path.skin[n] - path.skin[n - 1]);
  return length;
}

PathPlace place_along(const BladePath& path, double along) {
  for (std::size_t n = 0; n + 1 < path.skin.size(); n++) {
    const double length = norm(path.skin[n + 1] - path.skin[n]);
    if (along <= length || n + 2 == path.skin.size())
      return {n, length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0};
    along -= length;
  }
  return {};
}

Vec3d across_at(const BladePath& path, std::size_t n) {
  return normalized(cross(path.into[n], tangent(path.skin, n)));
}
Vec3d line_at(const BladePath& path, std::size_t n) { return cross(across_at(path, n), path.into[n]); }

Vec3d mean_into(const BladePath& path) {
  Vec3d sum;
  for (const Vec3d d : path.into) sum += d;
  return normalized(sum);
}

Result<BladePath> lay_blade(const Model& model, const State& state, const Incision& incision,
                            const HaloExchange* halo, std::span<const LaidBlade> laid) {
  const std::vector<Vec3d> points = drawn_points(model, incision);
  const bool straight = points.size() == 2;
  const std::string place = "incision '" + incision.name + "': ";
  for (std::size_t n = 1; n < points.size(); n++)
    if (!(norm(points[n] - points[n - 1]) > 0))
      return Error{place +
                   (straight ? "from and to are the same point" : "two points of its path are the same") +
                   ": expected a line on the skin"};
  if (!model.params.skin.enabled) return Error{place + "the body has no skin to cut: expected skin to be on"};

  const double step = smallest_step(model.lattice);
  std::vector<Vec3d> curve = drawn_curve(model, incision);
  std::array<MetLine, 2> met;
  if (incision.width == 0) met = meet_laid_blades(model, state, laid, halo, curve);
  const SkinNow near = skin_near(model, state, curve, halo);
  if (near.empty()) return Error{off_skin(model, state, place, curve[0])};
  BladePath path{.skin = curve,
                 .into = directions_into(model.lattice, near, curve, straight),
                 .depth = incision.depth,
                 .width = incision.width,
                 .edges = {},
                 .fine_edges = {},
                 .lines = {}};
  std::vector<double> offset;
  for (std::size_t n = 0; n < curve.size(); n++) {
    if (norm(path.into[n]) == 0)
      return Error{place + "the skin there has no direction: expected it to face out of the body"};
    const std::optional<double> found =
        way_to_skin(near, curve[n], path.into[n], across_at(path, n) * (1e-4 * step));
    if (!found) return Error{off_skin(model, state, place, curve[n])};
    offset.push_back(*found);
  }
  offset = without_stairs(offset);
  for (std::size_t n = 0; n < curve.size(); n++) path.skin[n] += path.into[n] * offset[n];
  const double margin = 2 * largest_step(model.lattice), tilt = incision.tilt * std::numbers::pi / 180;
  if (incision.width > 0) return path;
  BladeSheet sheet = sweep_blade(path, tilt, margin, 1e-4 * step);
  join_sheet(path, met, tilt, sheet);
  find_edges(model, state, sheet, halo, path);
  return path;
}

int cut_edges(const Model& model, State& state, const BladePath& path, double begin, double end, int incision,
              const DownloadNodes& bring) {
  constexpr double kFar = std::numeric_limits<double>::max();
  const double length = path_length(path);
  state.blades_on.set(std::uint8_t(incision), end < 1);
  begin = begin > 0 ? begin * length : -kFar, end = end < 1 ? end * length : kFar;
  int count = 0;
  for (const PendingEdgeCut& edge : path.edges) {
    if (double(edge.along) < begin || double(edge.along) >= end) continue;
    if (state.cut[std::size_t(edge.slot)] >> edge.family & 1) continue;
    cut_edge(model, state, edge.slot, edge.family);
    count++;
  }
  const std::size_t before = cut_version(state);
  cut_fine_edges(model, state, path, begin, end, incision);
  mark_cut_samples(model, state, path, begin, end, incision);
  if (count > 0) cut_skin(model, state);
  if (count > 0 || cut_version(state) > before) build_cut_elements(model, state, bring);
  return count;
}

int cut_region(const Model& model, State& state, const BladePath& path) {
  const Lattice& l = model.lattice;
  const double length = path_length(path), margin = 2 * largest_step(l);
  int count = 0;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Int3 node{i, j, k};
        const auto slot = std::size_t(node_slot(l, node));
        if (!is_body(model.tissue[slot]) || state.removed[slot]) continue;
        const Place place = place_on(path, Vec3d(position(model, state, node)));
        if (std::abs(place.aside) > 0.5 * path.width) continue;
        if (place.along < 0 || place.along > length || place.under < -margin || place.under > path.depth)
          continue;
        state.removed[slot] = 1;
        count++;
        for (int f = 0; f < kFamilyCount; f++)
          for (const Int3 lower : {node, node - kFamilies[std::size_t(f)]})
            if (contains(l, lower) && contains(l, lower + kFamilies[std::size_t(f)]) &&
                is_body(model.tissue[std::size_t(node_slot(l, lower))]))
              cut_edge(model, state, node_slot(l, lower), f);
      }
  state.removed_nodes += count;
  state.sleep.still.clear();  // everybody is awake
  if (count > 0) cut_skin(model, state);
  if (count > 0) build_cut_elements(model, state);
  return count;
}

}  // namespace turgor::lattice

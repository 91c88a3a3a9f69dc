#include "turgor/models/lattice/incision.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/geometry/where_is.hpp"
#include "turgor/models/lattice/skin.hpp"

namespace turgor::lattice {

namespace {

constexpr double kReach = 0.1;  // how far from the given line the skin may be [m]

Vec3d skin_corner(const Model& model, const State& state, const SkinTriangle& t, int corner) {
  return Vec3d(position(model, state, slot_node(model.lattice, t.vertex[corner])));
}

double smallest_step(const Lattice& l) { return std::min({l.step.x, l.step.y, l.step.z}); }
double largest_step(const Lattice& l) { return std::max({l.step.x, l.step.y, l.step.z}); }

/// Into the body: against the mean normal of the skin around the point of it that is nearest to `point`, at
/// right angles to `line`.
Vec3d direction_into(const Model& model, const State& state, Vec3d point, Vec3d line, double around) {
  double nearest = std::numeric_limits<double>::max();
  Vec3d centre;
  for (const SkinTriangle& t : model.skin.triangles)
    if (const Vec3d corner = skin_corner(model, state, t, 0); norm(corner - point) < nearest)
      nearest = norm(corner - point), centre = corner;
  Vec3d normal;
  for (const SkinTriangle& t : model.skin.triangles) {
    const Vec3d a = skin_corner(model, state, t, 0);
    if (norm(a - centre) > around) continue;
    normal += cross(skin_corner(model, state, t, 1) - a, skin_corner(model, state, t, 2) - a);
  }
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

struct Place {
  double along, under;  // from the start of the cut, below the skin [m]
};

/// Where a point of the blade's plane is, as the blade sees it.
Place place_on(const BladePath& path, Vec3d point) {
  const Vec3d line = cross(path.into, path.across);
  const double along = dot(point - path.skin.front(), line);
  const double last = double(path.skin.size() - 1),
               spacing = dot(path.skin.back() - path.skin.front(), line) / last;
  const double at = std::clamp(along / spacing, 0.0, last);
  const auto n = std::min(std::size_t(at), path.skin.size() - 2);
  const Vec3d skin = path.skin[n] + (path.skin[n + 1] - path.skin[n]) * (at - double(n));
  return {along, dot(point - skin, path.into)};
}

/// A node as it lay when the blade was set on the skin. What the wound does to the tissue ahead of the blade
/// does not bend the cut: else it would leave bridges and islands.
Vec3d place_when_laid(const Model& model, const BladePath& path, Int3 node) {
  return Vec3d(rest_position(model.lattice, node) + path.u[std::size_t(node_slot(model.lattice, node))]);
}

double path_length(const BladePath& path) {
  return dot(path.skin.back() - path.skin.front(), cross(path.into, path.across));
}

void mark_rows(const Model& model, State& state, int slot) {
  const int stride = row_stride(model.lattice), layer = layer_stride(model.lattice);
  for (int dk = -1; dk <= 1; dk++)
    for (int dj = -1; dj <= 1; dj++)
      state.row_cut[std::size_t((slot + dk * layer + dj * stride) / stride)] = 1;
}

void cut_edge(const Model& model, State& state, const CutEdge& edge) {
  state.cut[std::size_t(edge.slot)] |= std::uint8_t(1u << edge.family);
  state.cut_edges.push_back(edge);
  mark_rows(model, state, edge.slot);
}

}  // namespace

Result<BladePath> lay_blade(const Model& model, const State& state, const Incision& incision) {
  const auto local = [&](Vec3d p) { return inverse(model.grid.axes) * (p - model.grid.origin); };
  const Vec3d from = local(incision.from), to = local(incision.to);
  const double length = norm(to - from);
  const std::string place = "incision '" + incision.name + "': ";
  if (!(length > 0)) return Error{place + "from and to are the same point: expected a line on the skin"};
  if (model.skin.triangles.empty())
    return Error{place + "the body has no skin to cut: expected skin to be on"};

  BladePath path;
  path.depth = incision.depth;
  path.u = state.u;
  const Vec3d line = (to - from) / length;
  const double step = smallest_step(model.lattice);
  path.into =
      direction_into(model, state, (from + to) * 0.5, line, std::max(0.01, 3 * largest_step(model.lattice)));
  if (norm(path.into) == 0)
    return Error{place + "the skin there has no direction: expected it to face out of the body"};
  path.across = cross(line, path.into);

  std::vector<std::array<Vec3d, 3>> near;  // skin that the blade's plane may meet
  for (const SkinTriangle& t : model.skin.triangles) {
    const Vec3d a = skin_corner(model, state, t, 0);
    if (std::abs(dot(a - from, path.across)) > 3 * largest_step(model.lattice)) continue;
    near.push_back({a, skin_corner(model, state, t, 1), skin_corner(model, state, t, 2)});
  }
  const int pieces = std::max(1, int(std::ceil(length / (0.5 * step))));
  for (int n = 0; n <= pieces; n++) {
    // A hair's breadth beside the plane, so that no line runs through the corners of a regular lattice.
    const Vec3d point = from + line * (length * n / pieces) + path.across * (1e-4 * step);
    double best = kReach;
    bool found = false;
    for (const auto& [a, b, c] : near)
      if (const double t = meet(point, path.into, a, b, c); std::abs(t) < std::abs(best))
        best = t, found = true;
    if (!found) return Error{off_skin(model, state, place, point)};
    path.skin.push_back(point + path.into * best);
  }
  return path;
}

int cut_edges(const Model& model, State& state, const BladePath& path, double begin, double end,
              int incision) {
  const Lattice& l = model.lattice;
  const Vec3d origin = path.skin.front();
  const double length = path_length(path), margin = 2 * largest_step(l);
  const double reach = 1.8 * largest_step(l) + path.depth;
  int count = 0;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Int3 node{i, j, k};
        const int slot = node_slot(l, node);
        if (!is_body(model.tissue[std::size_t(slot)])) continue;
        const Vec3d a = place_when_laid(model, path, node);
        const double side_a = dot(a - origin, path.across);
        if (std::abs(side_a) > reach) continue;
        for (int f = 0; f < kFamilyCount; f++) {
          const Int3 other = node + kFamilies[std::size_t(f)];
          if (!contains(l, other) || state.cut[std::size_t(slot)] >> f & 1) continue;
          if (!is_body(model.tissue[std::size_t(node_slot(l, other))])) continue;
          const Vec3d b = place_when_laid(model, path, other);
          const double side_b = dot(b - origin, path.across);
          if ((side_a >= 0) == (side_b >= 0)) continue;
          const double fraction = side_a / (side_a - side_b);
          const Place hit = place_on(path, a + (b - a) * fraction);
          if (hit.along < begin * length || hit.along > end * length) continue;
          if (hit.under < -margin || hit.under > path.depth) continue;
          cut_edge(model, state, {slot, std::uint8_t(f), std::uint8_t(incision), Real(fraction)});
          count++;
        }
      }
  if (count > 0) cut_skin(model, state);
  return count;
}

int cut_region(const Model& model, State& state, const BladePath& path, double width, int incision) {
  const Lattice& l = model.lattice;
  const double length = path_length(path), margin = 2 * largest_step(l);
  int count = 0;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Int3 node{i, j, k};
        const auto slot = std::size_t(node_slot(l, node));
        if (!is_body(model.tissue[slot]) || state.removed[slot]) continue;
        const Vec3d x = place_when_laid(model, path, node);
        const Place place = place_on(path, x);
        if (std::abs(dot(x - path.skin.front(), path.across)) > 0.5 * width) continue;
        if (place.along < 0 || place.along > length || place.under < -margin || place.under > path.depth)
          continue;
        state.removed[slot] = 1;
        count++;
        for (std::size_t f = 0; f < kFamilyCount; f++)
          for (const bool forward : {true, false}) {
            const Int3 other = forward ? node + kFamilies[f] : node - kFamilies[f];
            if (!contains(l, other)) continue;
            const int lower = node_slot(l, forward ? node : other);
            if (state.cut[std::size_t(lower)] >> f & 1) continue;
            cut_edge(model, state, {lower, std::uint8_t(f), std::uint8_t(incision), Real(0.5)});
          }
      }
  if (count > 0) cut_skin(model, state);
  return count;
}

}  // namespace turgor::lattice

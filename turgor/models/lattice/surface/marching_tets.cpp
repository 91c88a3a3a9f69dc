#include "turgor/models/lattice/surface/marching_tets.hpp"

#include <cstddef>

namespace turgor::lattice {

namespace {

bool is_cut(const TetPattern& pattern, int i, int j) { return pattern.cut[std::size_t(i)][std::size_t(j)]; }
bool is_solid(const TetPattern& pattern, int i) { return pattern.solid[std::size_t(i)]; }

/// The step from the last point of one side of a cut to the first of the other.
bool is_gap(TetPoint p, TetPoint q) {
  return is_cut_point(p) && is_cut_point(q) && p.i == q.j && p.j == q.i && is_crossing(p) == is_crossing(q);
}

/// Skin from point to point, through the cut when they are on two sides of one.
void add_skin_segment(const TetPattern& pattern, TetPolygon& polygon, TetPoint from, TetPoint to) {
  polygon.add(from);
  if (from.i == to.i || !is_cut(pattern, from.i, to.i)) return;
  polygon.add(clip_point(from.i, to.i, from.b));
  polygon.add(clip_point(to.i, from.i, from.b));
}

/// One gap leaves a polygon in one piece, seen from the point opposite; more gaps part it. `middle` ≥ 0 is
/// the corner for middle points where three sides meet.
TetPolygons split_at_gaps(const TetPolygon& whole, int middle) {
  int gaps = 0, first = 0;
  for (int n = 0; n < whole.count; n++)
    if (is_gap(whole.at(n), whole.at(n + 1))) gaps++, first = n + 1;
  TetPolygons result;
  if (gaps < 2) {
    TetPolygon polygon;
    for (int n = 0; n < whole.count; n++) polygon.add(whole.at(gaps == 0 ? n : first + 2 + n));
    if (whole.count > 0) result.add(polygon);
    return result;
  }
  TetPolygon part;
  for (int n = 0; n < whole.count; n++) {
    const TetPoint p = whole.at(first + n);
    part.add(p);
    if (!is_gap(p, whole.at(first + n + 1))) continue;
    if (gaps == 3 && middle >= 0) part.add(middle_point(p.i, middle));
    result.add(part);
    part = {};
  }
  return result;
}

TetPolygon face_outline(const TetPattern& pattern, int face) {
  const auto& corners = kTetFaces[std::size_t(face)];
  TetPolygon outline;
  for (std::size_t n = 0; n < 3; n++) {
    const int p = corners[n], q = corners[(n + 1) % 3], r = corners[(n + 2) % 3];
    if (is_solid(pattern, p)) outline.add(corner_point(p));
    if (is_solid(pattern, p) && is_solid(pattern, q) && is_cut(pattern, p, q)) {
      outline.add(crossing_point(p, q));
      outline.add(crossing_point(q, p));
    }
    // Where the walk leaves the tissue, the skin leads to where it comes back.
    if (is_solid(pattern, p) && !is_solid(pattern, q)) {
      const TetPoint back = is_solid(pattern, r) ? skin_point(r, q) : skin_point(p, r);
      add_skin_segment(pattern, outline, skin_point(p, q), back);
      outline.add(back);
    }
  }
  return outline;
}

struct Links {
  std::array<TetPoint, 64> next;
  std::array<bool, 64> known{};

  static std::size_t code(TetPoint p) { return std::size_t(p.i + 4 * p.j + 16 * p.b); }
  void add(TetPoint from, TetPoint to) { next[code(from)] = to, known[code(from)] = true; }
  /// Follows and forgets the cycle through `start`.
  TetPolygon take_cycle(TetPoint start) {
    TetPolygon cycle;
    for (TetPoint p = start; known[code(p)]; p = next[code(p)]) {
      known[code(p)] = false;
      cycle.add(p);
    }
    return cycle;
  }
};

/// Walls run against the polygons that they border on.
void add_wall_links(const TetPolygons& polygons, Links& links) {
  for (int n = 0; n < polygons.count; n++) {
    const TetPolygon& polygon = polygons.polygons[std::size_t(n)];
    for (int m = 0; m < polygon.count; m++)
      if (is_cut_point(polygon.at(m)) && is_cut_point(polygon.at(m + 1)))
        links.add(polygon.at(m + 1), polygon.at(m));
  }
}

}  // namespace

TetPolygons face_polygons(const TetPattern& pattern, int face) {
  return split_at_gaps(face_outline(pattern, face), -1);
}

TetPolygons skin_polygons(const TetPattern& pattern, TetPolygon& outline) {
  // The skin borders on the faces' outlines, and runs against them.
  Links links;
  TetPoint start;
  bool any = false;
  for (int face = 0; face < 4; face++) {
    const auto& corners = kTetFaces[std::size_t(face)];
    for (std::size_t n = 0; n < 3; n++) {
      const int p = corners[n], q = corners[(n + 1) % 3], r = corners[(n + 2) % 3];
      if (!is_solid(pattern, p) || is_solid(pattern, q)) continue;
      start = is_solid(pattern, r) ? skin_point(r, q) : skin_point(p, r);
      links.add(start, skin_point(p, q));
      any = true;
    }
  }
  if (!any) return {};
  outline = links.take_cycle(start);
  TetPolygon whole;
  for (int n = 0; n < outline.count; n++) add_skin_segment(pattern, whole, outline.at(n), outline.at(n + 1));
  return split_at_gaps(whole, outline.at(0).b);
}

TetPolygons wall_polygons(const TetPattern& pattern) {
  Links links;
  for (int face = 0; face < 4; face++) add_wall_links(face_polygons(pattern, face), links);
  TetPolygon outline;
  add_wall_links(skin_polygons(pattern, outline), links);
  TetPolygons walls;
  for (std::size_t code = 0; code < 64; code++) {
    if (!links.known[code]) continue;
    const TetPolygon cycle =
        links.take_cycle({std::int8_t(code % 4), std::int8_t(code / 4 % 4), std::int8_t(code / 16)});
    if (cycle.count > 2) walls.add(cycle);
  }
  return walls;
}

}  // namespace turgor::lattice

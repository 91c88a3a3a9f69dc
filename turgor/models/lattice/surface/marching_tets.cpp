#include "turgor/models/lattice/surface/marching_tets.hpp"

#include <cstddef>

namespace turgor::lattice {

namespace {

bool is_cut(const TetPattern& pattern, int i, int j) { return pattern.cut[std::size_t(i)][std::size_t(j)]; }
bool is_solid(const TetPattern& pattern, int i) { return pattern.solid[std::size_t(i)]; }

/// True for the segment from the last point on one side of a cut to the first point on the other side.
bool is_gap(TetPoint p, TetPoint q) {
  return is_cut_point(p) && is_cut_point(q) && p.i == q.j && p.j == q.i && is_crossing(p) == is_crossing(q);
}

/// Adds the skin from point to point, across the cut if they are on its two sides.
void add_skin_segment(const TetPattern& pattern, TetPolygon& polygon, TetPoint from, TetPoint to) {
  polygon.add(from);
  if (from.i == to.i || !is_cut(pattern, from.i, to.i)) return;
  polygon.add(clip_point(from.i, to.i, from.b));
  polygon.add(clip_point(to.i, from.i, from.b));
}

/// Splits a polygon at its gaps. With one gap it remains one polygon, which starts opposite the gap. If
/// `middle` ≥ 0, it is the air corner of the middle point where three sides meet.
TetPolygons split_at_gaps(const TetPolygon& whole, int middle) {
  // count gaps
  int gaps = 0, first = 0;
  for (int n = 0; n < whole.count; n++)
    if (is_gap(whole.at(n), whole.at(n + 1))) gaps++, first = n + 1;
  TetPolygons result;
  // at most one gap: one polygon
  if (gaps < 2) {
    TetPolygon polygon;
    for (int n = 0; n < whole.count; n++) polygon.add(whole.at(gaps == 0 ? n : first + 2 + n));
    if (whole.count > 0) result.add(polygon);
    return result;
  }
  // several gaps: one polygon between each two
  TetPolygon polygon;
  for (int n = 0; n < whole.count; n++) {
    const TetPoint p = whole.at(first + n);
    polygon.add(p);
    if (!is_gap(p, whole.at(first + n + 1))) continue;
    if (gaps == 3 && middle >= 0) polygon.add(middle_point(p.i, middle));
    result.add(polygon);
    polygon = {};
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
    // from the point where the boundary leaves the tissue, the skin leads to the point where it re-enters
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
  std::array<bool, 64> is_linked{};

  static std::size_t code(TetPoint p) { return std::size_t(p.i + 4 * p.j + 16 * p.b); }
  void add(TetPoint from, TetPoint to) { next[code(from)] = to, is_linked[code(from)] = true; }
  /// Extracts the cycle through `start` and removes it.
  TetPolygon take_cycle(TetPoint start) {
    TetPolygon cycle;
    for (TetPoint p = start; is_linked[code(p)]; p = next[code(p)]) {
      is_linked[code(p)] = false;
      cycle.add(p);
    }
    return cycle;
  }
};

/// Links walls in the opposite direction of the polygons that they adjoin.
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
  // links run opposite to the outlines of the faces
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
  // one cycle, clipped at cuts
  outline = links.take_cycle(start);
  TetPolygon whole;
  for (int n = 0; n < outline.count; n++) add_skin_segment(pattern, whole, outline.at(n), outline.at(n + 1));
  return split_at_gaps(whole, outline.at(0).b);
}

TetPolygons wall_polygons(const TetPattern& pattern) {
  Links links;
  // boundary segments of the faces and the skin on cuts
  for (int face = 0; face < 4; face++) add_wall_links(face_polygons(pattern, face), links);
  TetPolygon outline;
  add_wall_links(skin_polygons(pattern, outline), links);
  // each cycle is a wall
  TetPolygons walls;
  for (std::size_t code = 0; code < 64; code++) {
    if (!links.is_linked[code]) continue;
    const TetPolygon cycle =
        links.take_cycle({std::int8_t(code % 4), std::int8_t(code / 4 % 4), std::int8_t(code / 16)});
    if (cycle.count > 2) walls.add(cycle);
  }
  return walls;
}

}  // namespace turgor::lattice

// The surface inside one tetrahedron, as polygons: skin between its solid and its other nodes, the tissue on
// each of its faces, and the walls where cut edges part it. Every polygon edge is shared by exactly two
// polygons of the tetrahedron and its neighbours, so that the whole is closed whatever is cut.
#pragma once

#include <array>
#include <cstdint>

namespace turgor::lattice {

/// A point by the corners it depends on (0…3), carried by `i`.
struct TetPoint {
  std::int8_t i = 0, j = 0, b = 0;

  friend bool operator==(TetPoint, TetPoint) = default;
};
constexpr TetPoint corner_point(int i) { return {std::int8_t(i), std::int8_t(i), std::int8_t(i)}; }
/// On the edge from solid i to other b, where the skin is.
constexpr TetPoint skin_point(int i, int b) { return {std::int8_t(i), std::int8_t(i), std::int8_t(b)}; }
/// On the cut edge ij, on the side of i.
constexpr TetPoint crossing_point(int i, int j) { return {std::int8_t(i), std::int8_t(j), std::int8_t(i)}; }
/// Between the skin points of ib and jb, where the edge ij is cut, on the side of i.
constexpr TetPoint clip_point(int i, int j, int b) {
  return {std::int8_t(i), std::int8_t(j), std::int8_t(b)};
}
/// In the middle of three skin points that are all apart, on the side of i.
constexpr TetPoint middle_point(int i, int b) { return {std::int8_t(i), std::int8_t(b), std::int8_t(b)}; }

constexpr bool is_corner(TetPoint p) { return p.j == p.i && p.b == p.i; }
constexpr bool is_skin_point(TetPoint p) { return p.j == p.i && p.b != p.i; }
constexpr bool is_crossing(TetPoint p) { return p.j != p.i && p.b == p.i; }
constexpr bool is_middle(TetPoint p) { return p.j != p.i && p.j == p.b; }
constexpr bool is_clip(TetPoint p) { return p.j != p.i && p.b != p.i && p.j != p.b; }
/// On the border of a wall?
constexpr bool is_cut_point(TetPoint p) { return p.j != p.i; }

struct TetPolygon {
  std::array<TetPoint, 16> points;
  int count = 0;

  void add(TetPoint p) { points[std::size_t(count++)] = p; }
  TetPoint at(int n) const { return points[std::size_t((n + count) % count)]; }
};
struct TetPolygons {
  std::array<TetPolygon, 4> polygons;
  int count = 0;

  void add(const TetPolygon& polygon) { polygons[std::size_t(count++)] = polygon; }
};

/// What there is to know: which corners are solid, and which edges between those are cut.
struct TetPattern {
  std::array<bool, 4> solid{};
  std::array<std::array<bool, 4>, 4> cut{};
};

/// The faces, counter-clockwise seen from outside, of a tetrahedron of positive volume; face f lacks corner
/// f.
constexpr std::array<std::array<int, 3>, 4> kTetFaces = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// The tissue on one face, counter-clockwise seen from outside.
TetPolygons face_polygons(const TetPattern& pattern, int face);
/// The skin, counter-clockwise seen from outside the body. `outline` receives the skin points alone, in
/// order.
TetPolygons skin_polygons(const TetPattern& pattern, TetPolygon& outline);
/// The walls of cuts, counter-clockwise seen from inside the cut.
TetPolygons wall_polygons(const TetPattern& pattern);

}  // namespace turgor::lattice

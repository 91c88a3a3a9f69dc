// Marching tetrahedra with cuts: the surface in one tetrahedron as polygons [Lorensen and Cline 1987; Doi and
// Koide 1991]. They are the skin between solid and other corners, the tissue on each face, and the walls at
// cut edges. Every polygon edge is shared by exactly two polygons of the tetrahedron and its neighbors, so
// the surface is closed for any cuts.
#pragma once

#include <array>
#include <cstdint>

namespace turgor::lattice {

/// Point of the surface, given by the corners (0…3) that it depends on. It belongs to the side of corner `i`.
struct TetPoint {
  std::int8_t i = 0, j = 0, b = 0;

  friend bool operator==(TetPoint, TetPoint) = default;
};
constexpr TetPoint corner_point(int i) { return {std::int8_t(i), std::int8_t(i), std::int8_t(i)}; }
/// Skin point on the edge from solid corner i to air corner b.
constexpr TetPoint skin_point(int i, int b) { return {std::int8_t(i), std::int8_t(i), std::int8_t(b)}; }
/// Crossing of the blade with the cut edge ij, on the side of i.
constexpr TetPoint crossing_point(int i, int j) { return {std::int8_t(i), std::int8_t(j), std::int8_t(i)}; }
/// Clip point between the skin points of ib and jb, where the edge ij is cut, on the side of i.
constexpr TetPoint clip_point(int i, int j, int b) {
  return {std::int8_t(i), std::int8_t(j), std::int8_t(b)};
}
/// Junction of three skin points that are pairwise separated, on the side of i.
constexpr TetPoint middle_point(int i, int b) { return {std::int8_t(i), std::int8_t(b), std::int8_t(b)}; }

constexpr bool is_corner(TetPoint p) { return p.j == p.i && p.b == p.i; }
constexpr bool is_skin_point(TetPoint p) { return p.j == p.i && p.b != p.i; }
constexpr bool is_crossing(TetPoint p) { return p.j != p.i && p.b == p.i; }
constexpr bool is_middle(TetPoint p) { return p.j != p.i && p.j == p.b; }
constexpr bool is_clip(TetPoint p) { return p.j != p.i && p.b != p.i && p.j != p.b; }
/// True for points on the border of a wall.
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

/// Input pattern: solid corners, and cut edges between solid corners.
struct TetPattern {
  std::array<bool, 4> solid{};
  std::array<std::array<bool, 4>, 4> cut{};
};

/// Faces of a tetrahedron with positive volume, counter-clockwise seen from outside. Face f is opposite
/// corner f.
constexpr std::array<std::array<int, 3>, 4> kTetFaces = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Tissue on one face, counter-clockwise seen from outside.
TetPolygons face_polygons(const TetPattern& pattern, int face);
/// Skin, counter-clockwise seen from outside the body. `outline` receives the skin points alone, in order.
TetPolygons skin_polygons(const TetPattern& pattern, TetPolygon& outline);
/// Walls of cuts, counter-clockwise seen from inside the cut.
TetPolygons wall_polygons(const TetPattern& pattern);

}  // namespace turgor::lattice

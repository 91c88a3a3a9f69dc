// One rectangle in different triangulations, for tests of results that must not depend on them.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/models/cloth/storm.hpp"
#include "turgor/models/cloth/build/sheet.hpp"

namespace turgor::cloth {

enum class Pattern { kDiagonal, kOtherDiagonal, kAlternating, kLong, kTall, kEquilateral, kRandom };
constexpr Pattern kPatterns[] = {Pattern::kDiagonal, Pattern::kOtherDiagonal, Pattern::kAlternating,
                                 Pattern::kLong,     Pattern::kTall,          Pattern::kEquilateral,
                                 Pattern::kRandom};

inline std::string name(Pattern pattern) {
  switch (pattern) {
    case Pattern::kDiagonal:
      return "squares";
    case Pattern::kOtherDiagonal:
      return "squares with the other diagonal";
    case Pattern::kAlternating:
      return "squares with alternating diagonals";
    case Pattern::kLong:
      return "cells four times as long";
    case Pattern::kTall:
      return "cells four times as high";
    case Pattern::kEquilateral:
      return "equilateral";
    case Pattern::kRandom:
      return "random";
  }
  return "";
}

/// Smaller area of two triangles of a mesh in the plane z = 0, negative if it is inverted [m²].
inline double smaller_area(const TriMesh& mesh, Int3 s, Int3 t) {
  const auto area = [&mesh](Int3 corners) {
    const auto [a, b, c] = corners;
    const auto at = [&mesh](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
    return cross(at(b) - at(a), at(c) - at(a)).z / 2;
  };
  return std::min(area(s), area(t));
}

/// A rectangle in the plane z = 0 from x0 to x1 and 0 to height, in triangles of about `size`, with columns
/// of vertices at x0, x0 + size and x1. Random cells have the diagonal that chance chooses unless it inverts
/// a triangle or nearly does.
inline TriMesh rectangle(Pattern pattern, double x0, double x1, double height, double size) {
  const double column = pattern == Pattern::kTall ? size / 4 : size;
  const double row = pattern == Pattern::kLong          ? size / 4
                     : pattern == Pattern::kEquilateral ? size * 0.866
                                                        : size;
  const int columns = int(std::lround((x1 - x0) / column)),
            rows = std::max(1, int(std::lround(height / row)));
  TriMesh mesh = make_sheet({.corner = {x0, 0, 0},
                             .side = {x1 - x0, 0, 0},
                             .up = {0, height, 0},
                             .columns = columns,
                             .rows = rows});
  RandomNumbers next{5};
  const auto at = [&](int c, int r) { return r * (columns + 1) + c; };
  for (int r = 0; r <= rows; r++)
    for (int c = 2; c < columns; c++) {
      Vec3& x = mesh.vertices[std::size_t(at(c, r))];
      if (pattern == Pattern::kEquilateral && r % 2 == 1) x.x += Real(column / 2);
      if (pattern != Pattern::kRandom) continue;
      const double along = next(), up = next();
      x.x += Real(0.3 * column * along);
      if (r > 0 && r < rows) x.y += Real(0.3 * height / rows * up);
    }
  mesh.triangles.clear();
  for (int r = 0; r < rows; r++)
    for (int c = 0; c < columns; c++) {
      const int a = at(c, r), b = at(c + 1, r), d = at(c, r + 1), e = at(c + 1, r + 1);
      bool other = pattern == Pattern::kOtherDiagonal;
      if (pattern == Pattern::kAlternating) other = (c + r) % 2 == 1;
      if (pattern == Pattern::kEquilateral) other = r % 2 == 0;
      if (pattern == Pattern::kRandom) {
        const double one = smaller_area(mesh, {a, b, e}, {a, e, d}),
                     another = smaller_area(mesh, {a, b, d}, {b, e, d}), enough = 0.1 * column * row;
        other = next() > 0;
        if ((other ? another : one) < enough) other = another > one;
      }
      if (other)
        mesh.triangles.push_back({a, b, d}), mesh.triangles.push_back({b, e, d});
      else
        mesh.triangles.push_back({a, b, e}), mesh.triangles.push_back({a, e, d});
    }
  return mesh;
}

/// Indices of the vertices of a mesh between two values of x.
inline std::vector<int> vertices_between(const TriMesh& mesh, double from, double to) {
  std::vector<int> found;
  for (std::size_t v = 0; v < mesh.vertices.size(); v++)
    if (double(mesh.vertices[v].x) > from && double(mesh.vertices[v].x) < to) found.push_back(int(v));
  return found;
}

}  // namespace turgor::cloth

// A vertex and a triangle, or two edges, on straight ways: the time is gone through in steps in which a plane
// between them shows that they cannot meet (conservative advancement), so nothing is missed at any speed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/geometry/triangle_point.hpp"
#include "turgor/models/cloth/device/sheet_view.hpp"

namespace turgor::cloth {

constexpr double kClosest = 0.02;  // thicknesses that are left between what would meet

/// From the second thing to the first, where they are nearest [m].
TURGOR_HD inline Vec3d between_edges(const std::array<Vec3d, 4>& x) {
  const Vec3d p = x[1] - x[0], q = x[3] - x[2], r = x[0] - x[2];
  const double pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), pr = dot(p, r), qr = dot(q, r);
  const double determinant = pp * qq - pq * pq;
  double s = determinant > 0 ? std::clamp((pq * qr - pr * qq) / determinant, 0.0, 1.0) : 0;
  double t = qq > 0 ? (pq * s + qr) / qq : 0;
  if (!(t >= 0 && t <= 1)) {
    t = std::clamp(t, 0.0, 1.0);
    s = pp > 0 ? std::clamp((pq * t - pr) / pp, 0.0, 1.0) : 0;
  }
  return r + p * s - q * t;
}

TURGOR_HD inline Vec3d between(const std::array<Vec3d, 4>& x, bool are_edges) {
  return are_edges ? between_edges(x) : x[0] - nearest_on_triangle(x[0], x[1], x[2], x[3]).place;
}

/// Of a vertex and a triangle or of two edges [m].
TURGOR_HD inline double gap_between(const std::array<Vec3d, 4>& x, bool are_edges) {
  return norm(between(x, are_edges));
}

/// Whether these come too near on the straight way from x to x + d [m].
TURGOR_HD inline bool comes_too_near(const std::array<Vec3d, 4>& x, const std::array<Vec3d, 4>& d,
                                     bool are_edges, double thickness) {
  constexpr int kSteps = 64;
  const double closest = kClosest * thickness;
  std::array<Vec3d, 4> y = x;
  double done = 0, least = 0;
  for (int step = 0; step < kSteps; step++) {
    const Vec3d way = between(y, are_edges);
    const double gap = norm(way);
    // What is nearer already may come nearer still, but not without end.
    if (step == 0) least = std::min(gap, std::clamp(gap / 2, closest / 16, closest));
    if (!(gap > 0)) return true;
    const Vec3d n = way / gap;
    const double first = are_edges ? std::min(dot(n, d[0]), dot(n, d[1])) : dot(n, d[0]);
    double second = std::max(dot(n, d[2]), dot(n, d[3]));
    if (!are_edges) second = std::max(second, dot(n, d[1]));
    const double closing = second - first;
    if (gap - closing * (1 - done) >= least) return false;
    const double room = gap - least;
    if (room <= 0.02 * least) return true;
    done += room / closing;
    for (std::size_t k = 0; k < 4; k++) y[k] = x[k] + d[k] * done;
  }
  return true;
}

/// Things on their ways through a step, and whether they meet there.
struct Ways {
  ConstVectorsView x, d, x_rest;  // places, displacements, places at rest [m]
  double thickness;               // [m]

  TURGOR_HD Vec3d place(int v) const { return Vec3d(x[std::size_t(v)]); }
  TURGOR_HD Vec3d way(int v) const { return Vec3d(d[std::size_t(v)]); }

  /// A vertex and a triangle, or two edges, on their ways as the first vertex sees them.
  struct Four {
    std::array<Vec3d, 4> x, d;
    bool are_edges;
  };
  TURGOR_HD Four four(const std::array<int, 4>& v, bool are_edges) const {
    Four f{{}, {}, are_edges};
    for (std::size_t k = 0; k < 4; k++) f.x[k] = place(v[k]), f.d[k] = way(v[k]) - way(v[0]);
    return f;
  }
  /// False: they move as one, or a plane across one of the axes parts them all the way.
  TURGOR_HD bool may_meet(const Four& f) const {
    bool moves_as_one = true;
    for (std::size_t k = 0; k < 4; k++) moves_as_one = moves_as_one && f.d[k] == Vec3d{};
    if (moves_as_one) return false;
    const double margin = kClosest * thickness;
    const int first = f.are_edges ? 2 : 1;
    for (int k = 0; k < 3; k++) {
      double low[2]{INFINITY, INFINITY}, high[2]{-INFINITY, -INFINITY};
      for (int n = 0; n < 4; n++) {
        const double from = f.x[std::size_t(n)][k], to = from + f.d[std::size_t(n)][k];
        const int side = n < first ? 0 : 1;
        low[side] = std::min(low[side], std::min(from, to));
        high[side] = std::max(high[side], std::max(from, to));
      }
      if (low[0] > high[1] + margin || low[1] > high[0] + margin) return false;
    }
    return true;
  }
  /// Seams that are not closed touch at rest: nothing keeps them apart.
  TURGOR_HD bool meet(const Four& f, const std::array<int, 4>& v) const {
    if (!comes_too_near(f.x, f.d, f.are_edges, thickness)) return false;
    std::array<Vec3d, 4> rest;
    for (std::size_t k = 0; k < 4; k++) rest[k] = Vec3d(x_rest[std::size_t(v[k])]);
    return !(gap_between(rest, f.are_edges) < kClosest * thickness / 16);
  }
};

}  // namespace turgor::cloth

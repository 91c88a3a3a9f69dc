// Collision test of a vertex and a triangle, or of two edges, in linear motion. Conservative advancement:
// time advances in steps in which a separating plane excludes a collision, so nothing is missed at any speed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/geometry/triangle_point.hpp"
#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth {

/// Motion of a step as CCD sees it. The arrays are those of System, which are unused after the solution;
/// separate arrays would add 44 bytes to each vertex.
struct CcdMotion {
  VectorsView start;         // positions at the beginning of the step [m]
  VectorsView displacement;  // in the step [m]
  VectorsView normal;        // sum of the normals of incident triangles at the beginning of the step [m²]
  Real* longest2;            // longest edge of incident triangles, squared [m²]
  Real* flatness;            // 2: incident normals stay within 30° of one direction; 1: within 45°; else 0
};
TURGOR_HD inline CcdMotion ccd_motion(const SheetView& sheet) {
  return {sheet.previous, sheet.force, sheet.inverse[1], sheet.inverse[0].x, sheet.inverse[0].y};
}

constexpr double kClosest = 0.02;  // smallest distance that CCD leaves, relative to the thickness

/// Vector between the nearest points of two edges, from the second to the first [m].
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

/// Vector between the nearest points, from the triangle to the vertex or from the second edge to the first
/// [m].
TURGOR_HD inline Vec3d between(const std::array<Vec3d, 4>& x, bool are_edges) {
  return are_edges ? between_edges(x) : x[0] - nearest_on_triangle(x[0], x[1], x[2], x[3]).position;
}

/// Distance of a vertex and a triangle, or of two edges [m].
TURGOR_HD inline double gap_between(const std::array<Vec3d, 4>& x, bool are_edges) {
  return norm(between(x, are_edges));
}

/// Conservative advancement. With gap g and normal n of the nearest points at time s, the primitives cannot
/// come nearer than `least` before s + (g − least)/c, where c is the largest closing speed of their vertices
/// along n. True if they come nearer than `least` in the motion from x to x + d [m]; `time` is when they are
/// that near [1].
TURGOR_HD inline bool comes_too_near(const std::array<Vec3d, 4>& x, const std::array<Vec3d, 4>& d,
                                     bool are_edges, double thickness, double& time) {
  constexpr int kSteps = 64;
  const double closest = kClosest * thickness;
  std::array<Vec3d, 4> y = x;
  double least = 0;
  time = 0;
  for (int step = 0; step < kSteps; step++) {
    // gap and normal
    const Vec3d offset = between(y, are_edges);
    const double gap = norm(offset);
    // Primitives that are nearer already may approach further, within limits.
    if (step == 0) least = std::min(gap, std::clamp(gap / 2, closest / 16, closest));
    if (!(gap > 0)) return true;
    const Vec3d n = offset / gap;
    // largest closing speed along the normal
    const double first = are_edges ? std::min(dot(n, d[0]), dot(n, d[1])) : dot(n, d[0]);
    double second = std::max(dot(n, d[2]), dot(n, d[3]));
    if (!are_edges) second = std::max(second, dot(n, d[1]));
    const double closing = second - first;
    // safe advance
    if (gap - closing * (1 - time) >= least) return false;
    const double advance = gap - least;
    if (advance <= 0.02 * least) return true;
    time += advance / closing;
    for (std::size_t k = 0; k < 4; k++) y[k] = x[k] + d[k] * time;
  }
  return true;
}
TURGOR_HD inline bool comes_too_near(const std::array<Vec3d, 4>& x, const std::array<Vec3d, 4>& d,
                                     bool are_edges, double thickness) {
  double time;
  return comes_too_near(x, d, are_edges, thickness, time);
}

/// Linear motion of the vertices in a step, and its collision tests.
struct LinearMotion {
  ConstVectorsView x, d, x_rest;  // positions, displacements, rest positions [m]
  double thickness;               // [m]

  TURGOR_HD Vec3d position(int v) const { return Vec3d(x[std::size_t(v)]); }
  TURGOR_HD Vec3d displacement(int v) const { return Vec3d(d[std::size_t(v)]); }

  /// Vertex and triangle, or two edges, with displacements relative to the first vertex.
  struct PrimitivePair {
    std::array<Vec3d, 4> x, d;
    bool are_edges;
  };
  TURGOR_HD PrimitivePair primitives(const std::array<int, 4>& v, bool are_edges) const {
    PrimitivePair f{{}, {}, are_edges};
    for (std::size_t k = 0; k < 4; k++)
      f.x[k] = position(v[k]), f.d[k] = displacement(v[k]) - displacement(v[0]);
    return f;
  }
  /// False: they move rigidly together, or an axis separates them during the whole motion.
  TURGOR_HD bool may_collide(const PrimitivePair& f) const {
    bool moves_as_one = true;
    for (std::size_t k = 0; k < 4; k++) moves_as_one = moves_as_one && f.d[k] == Vec3d{};
    if (moves_as_one) return false;
    // bounds of both primitives along each axis
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
  /// Collision test. Primitives that touch at rest, such as open seams, are excluded.
  TURGOR_HD bool collide(const PrimitivePair& f, const std::array<int, 4>& v) const {
    if (!comes_too_near(f.x, f.d, f.are_edges, thickness)) return false;
    std::array<Vec3d, 4> rest;
    for (std::size_t k = 0; k < 4; k++) rest[k] = Vec3d(x_rest[std::size_t(v[k])]);
    return !(gap_between(rest, f.are_edges) < kClosest * thickness / 16);
  }
};

}  // namespace turgor::cloth

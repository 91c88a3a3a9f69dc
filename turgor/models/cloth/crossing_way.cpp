// A vertex and a triangle, or two edges, on straight ways: the time is gone through in steps in which a plane
// between them shows that they cannot meet (conservative advancement), so nothing is missed at any speed.
#include <algorithm>
#include <cmath>

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/cloth/crossing.hpp"

namespace turgor::cloth {

namespace {

/// From the second thing to the first, where they are nearest [m].
Vec3d between_edges(const std::array<Vec3d, 4>& x) {
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

Vec3d between(const std::array<Vec3d, 4>& x, bool are_edges) {
  return are_edges ? between_edges(x) : x[0] - nearest_on_triangle(x[0], x[1], x[2], x[3]).place;
}

}  // namespace

double gap_between(const std::array<Vec3d, 4>& x, bool are_edges) { return norm(between(x, are_edges)); }

bool comes_too_near(const std::array<Vec3d, 4>& x, const std::array<Vec3d, 4>& d, bool are_edges,
                    double thickness) {
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

}  // namespace turgor::cloth

// Which of sixteen vertices are near to a large triangle, and which of sixteen edges to a large edge, and not
// as they lie in a sheet that is straight. They only sieve, with some slack: what passes is looked at one by
// one (contact_coarse.cpp). In a sheet that is not folded hardly anything passes.
#pragma once

#include <bit>
#include <cmath>
#include <vector>

#include "turgor/models/cloth/vectors.hpp"

namespace turgor::cloth {

/// Of the way along the sheet: what is farther apart than this is not folded.
inline constexpr Real kStraight = Real(0.9);

/// How near two places must be to touch.
struct Nearness {
  Real reach = 0, thickness = 0;  // [m]

  /// By the squares of how far places are from each other, now and along the sheet at rest.
  unsigned folded(Lanes apart2, Lanes along2) const {
    constexpr Real kSlack = Real(0.02);
    return lanes_below(apart2, reach * reach * (1 + kSlack)) &
           lanes_below(apart2 - along2 * (kStraight * kStraight * (1 + kSlack)), 0) &
           lanes_below(thickness * thickness * (1 - kSlack) - along2, 0);
  }
};

inline unsigned lanes_inside(Vec3 low, Vec3 high, Lanes3 p) {
  const Lanes x = larger(low.x - p.x, p.x - high.x), y = larger(low.y - p.y, p.y - high.y),
              z = larger(low.z - p.z, p.z - high.z);
  return lanes_below(larger(x, larger(y, z)), 0);
}

inline Lanes3 minus(Lanes3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Lanes along(Lanes3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/// a − v·p − w·q.
inline Lanes3 off(Lanes3 a, Lanes v, Vec3 p, Lanes w, Vec3 q) {
  return {a.x - v * p.x - w * q.x, a.y - v * p.y - w * q.y, a.z - v * p.z - w * q.z};
}

inline Lanes3 off(Lanes3 a, Lanes s, Vec3 p) { return {a.x - s * p.x, a.y - s * p.y, a.z - s * p.z}; }

/// A corner of a triangle, and the ways from there to the other two.
struct Corner {
  Vec3 at, p, q;
};

/// What is near to some triangles or edges that lie side by side: all that any of them has to look at.
struct Neighbourhood {
  std::vector<int> index;  // of vertices, or edges
  Vectors at, rest;        // their places, or edges' middles [m]
  Vectors way, rest_way;   // of edges, to their ends [m]
};

/// Calls visit(index) for all there that pass, sixteen at a time.
template <class Passes, class Visit>
void visit_neighbours(const Neighbourhood& near, const Passes& passes, const Visit& visit) {
  for (std::size_t n = 0; n < near.index.size(); n += std::size_t(kLanes)) {
    unsigned hits = passes(near, n);
    if (const std::size_t left = near.index.size() - n; left < std::size_t(kLanes)) hits &= (1u << left) - 1;
    for (; hits != 0; hits &= hits - 1) visit(near.index[n + std::size_t(std::countr_zero(hits))]);
  }
}

/// Vertices near a triangle.
struct NearTriangle {
  Nearness nearness;
  Vec3 low, high;    // what is farther is not near
  Corner now, rest;  // [m]

  unsigned operator()(const Neighbourhood& near, std::size_t first) const {
    const Lanes3 point = load(near.at, first);
    const unsigned bits = lanes_inside(low, high, point);
    if (bits == 0) return 0;
    const Vec3 p = now.p, q = now.q, side = q - p;
    const Real pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), determinant = pp * qq - pq * pq;
    if (!(determinant > Real(1e-3) * pp * qq)) return bits;  // a needle: the nearest place is uncertain
    const Lanes3 d = minus(point, now.at);
    const Lanes dp = along(d, p), dq = along(d, q);
    const Lanes zero = all_lanes(0), one = all_lanes(1);
    const auto between = [&](Lanes t) { return smaller(larger(t, zero), one); };
    // Inside, or else on the side that is nearest.
    Lanes v = (dp * qq - dq * pq) * (1 / determinant), w = (dq * pp - dp * pq) * (1 / determinant);
    const Lanes outside = larger(larger(-v, -w), v + w - 1);
    Lanes3 gap = off(d, v, p, w, q);
    Lanes least2 = outside > zero ? all_lanes(INFINITY) : dot(gap, gap);
    const auto take = [&](Lanes to_p, Lanes to_q) {
      const Lanes3 there = off(d, to_p, p, to_q, q);
      const Lanes apart2 = dot(there, there);
      v = apart2 < least2 ? to_p : v, w = apart2 < least2 ? to_q : w, least2 = smaller(apart2, least2);
    };
    const Lanes along_side = between((along(d, side) - dot(p, side)) * (1 / dot(side, side)));
    take(between(dp * (1 / pp)), zero);
    take(zero, between(dq * (1 / qq)));
    take(1 - along_side, along_side);
    const Lanes3 at_rest = off(minus(load(near.rest, first), rest.at), v, rest.p, w, rest.q);
    return bits & nearness.folded(least2, dot(at_rest, at_rest));
  }
};

/// An edge from end to end.
struct Way {
  Vec3 from, p;
};
/// Edges that come nearest to an edge inside of both. Rounding lets some more through.
struct NearEdge {
  Nearness nearness;
  Vec3 low, high;  // a middle that is farther is not near
  Way now, rest;

  unsigned operator()(const Neighbourhood& near, std::size_t first) const {
    constexpr Real kSlack = Real(1e-3), kParallel = Real(5e-7), kUncertain = Real(1e-3);
    const Lanes3 middle = load(near.at, first), q = load(near.way, first);
    const unsigned bits = lanes_inside(low, high, middle);
    if (bits == 0) return 0;
    const Vec3 p = now.p;
    const Lanes3 d = minus(middle - q * all_lanes(0.5f), now.from);
    const Lanes pq = along(q, p), qq = dot(q, q), dp = along(d, p), dq = dot(d, q);
    const Lanes product = qq * dot(p, p), determinant = product - pq * pq;
    const Lanes ds = dp * qq - dq * pq, dt = dp * pq - dq * dot(p, p);
    const Lanes beyond = larger(larger(-ds, ds - determinant), larger(-dt, dt - determinant));
    const unsigned meet = bits & lanes_below(beyond - determinant * kSlack, 0) &
                          lanes_below(product * kParallel - determinant, 0);
    if (meet == 0) return 0;
    const Lanes s = ds / determinant, t = dt / determinant;
    const Lanes3 gap = off(d + q * t, s, p);
    const Lanes3 at_rest =
        off(minus(load(near.rest, first) + load(near.rest_way, first) * (t - 0.5f), rest.from), s, rest.p);
    const unsigned uncertain = lanes_below(determinant - product * kUncertain, 0);
    return meet & (uncertain | nearness.folded(dot(gap, gap), dot(at_rest, at_rest)));
  }
};

}  // namespace turgor::cloth

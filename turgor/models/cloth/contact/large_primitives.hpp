// Which vertices are near to a large triangle, and which edges to a large edge, and not as they lie in a
// sheet that is straight: of sixteen at once (T = Lanes), or of one (T = Real). They only sieve, with some
// slack: what passes is looked at one by one (coarse_loops.hpp). In a sheet that is not folded hardly
// anything passes.
#pragma once

#include <cmath>

#include "turgor/models/cloth/device/sheet_view.hpp"

namespace turgor::cloth {

/// Of the way along the sheet: what is farther apart than this is not folded.
inline constexpr Real kStraight = Real(0.9);

/// A bit for each of them that is below b.
TURGOR_HD inline unsigned bits_below(Real a, Real b) { return a < b ? 1 : 0; }
inline unsigned bits_below(Lanes a, Real b) { return lanes_below(a, b); }

/// How near two places must be to touch.
struct Nearness {
  Real reach = 0, thickness = 0;  // [m]

  /// By the squares of how far places are from each other, now and along the sheet at rest.
  template <class T>
  TURGOR_HD unsigned folded(T apart2, T along2) const {
    constexpr Real kSlack = Real(0.02);
    return bits_below(apart2, reach * reach * (1 + kSlack)) &
           bits_below(apart2 - along2 * (kStraight * kStraight * (1 + kSlack)), 0) &
           bits_below(thickness * thickness * (1 - kSlack) - along2, 0);
  }
};

template <class T>
TURGOR_HD inline unsigned bits_inside(Vec3 low, Vec3 high, const Three<T>& p) {
  const T x = larger(low.x - p.x, p.x - high.x), y = larger(low.y - p.y, p.y - high.y),
          z = larger(low.z - p.z, p.z - high.z);
  return bits_below(larger(x, larger(y, z)), 0);
}

template <class T>
TURGOR_HD inline Three<T> minus(const Three<T>& a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
TURGOR_HD inline T along(const Three<T>& a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// a − v·p − w·q.
template <class T>
TURGOR_HD inline Three<T> off(const Three<T>& a, T v, Vec3 p, T w, Vec3 q) {
  return {a.x - v * p.x - w * q.x, a.y - v * p.y - w * q.y, a.z - v * p.z - w * q.z};
}
template <class T>
TURGOR_HD inline Three<T> off(const Three<T>& a, T s, Vec3 p) {
  return {a.x - s * p.x, a.y - s * p.y, a.z - s * p.z};
}

/// A corner of a triangle, and the ways from there to the other two.
struct Corner {
  Vec3 at, p, q;
};

/// Vertices near a triangle.
struct NearTriangle {
  Nearness nearness;
  Vec3 low, high;    // what is farther is not near
  Corner now, rest;  // [m]

  template <class T>
  TURGOR_HD unsigned passes(const Three<T>& point, const Three<T>& point_rest) const {
    const unsigned bits = bits_inside<T>(low, high, point);
    if (bits == 0) return 0;
    const Vec3 p = now.p, q = now.q, side = q - p;
    const Real pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), determinant = pp * qq - pq * pq;
    if (!(determinant > Real(1e-3) * pp * qq)) return bits;  // a needle: the nearest place is uncertain
    const Three<T> d = minus<T>(point, now.at);
    const T dp = along<T>(d, p), dq = along<T>(d, q);
    const T zero = all_of<T>(0), one = all_of<T>(1);
    const auto between = [&](T t) { return smaller(larger(t, zero), one); };
    // Inside, or else on the side that is nearest.
    T v = (dp * qq - dq * pq) * (1 / determinant), w = (dq * pp - dp * pq) * (1 / determinant);
    const T outside = larger(larger(-v, -w), v + w - 1);
    const Three<T> gap = off<T>(d, v, p, w, q);
    T least2 = outside > zero ? all_of<T>(INFINITY) : dot(gap, gap);
    const auto take = [&](T to_p, T to_q) {
      const Three<T> there = off<T>(d, to_p, p, to_q, q);
      const T apart2 = dot(there, there);
      v = apart2 < least2 ? to_p : v, w = apart2 < least2 ? to_q : w, least2 = smaller(apart2, least2);
    };
    const T along_side = between((along<T>(d, side) - dot(p, side)) * (1 / dot(side, side)));
    take(between(dp * (1 / pp)), zero);
    take(zero, between(dq * (1 / qq)));
    take(1 - along_side, along_side);
    const Three<T> at_rest = off<T>(minus<T>(point_rest, rest.at), v, rest.p, w, rest.q);
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

  /// By middles of edges and the ways to their ends, now and at rest.
  template <class T>
  TURGOR_HD unsigned passes(const Three<T>& middle, const Three<T>& q, const Three<T>& middle_rest,
                            const Three<T>& q_rest) const {
    constexpr Real kSlack = Real(1e-3), kParallel = Real(5e-7), kUncertain = Real(1e-3);
    const unsigned bits = bits_inside<T>(low, high, middle);
    if (bits == 0) return 0;
    const Vec3 p = now.p;
    const Three<T> d = minus<T>(middle - q * all_of<T>(0.5f), now.from);
    const T pq = along<T>(q, p), qq = dot(q, q), dp = along<T>(d, p), dq = dot(d, q);
    const T product = qq * dot(p, p), determinant = product - pq * pq;
    const T ds = dp * qq - dq * pq, dt = dp * pq - dq * dot(p, p);
    const T beyond = larger(larger(-ds, ds - determinant), larger(-dt, dt - determinant));
    const unsigned meet = bits & bits_below(beyond - determinant * kSlack, 0) &
                          bits_below(product * kParallel - determinant, 0);
    if (meet == 0) return 0;
    const T s = ds / determinant, t = dt / determinant;
    const Three<T> gap = off<T>(d + q * t, s, p);
    const Three<T> at_rest = off<T>(minus<T>(middle_rest + q_rest * (t - 0.5f), rest.from), s, rest.p);
    const unsigned uncertain = bits_below(determinant - product * kUncertain, 0);
    return meet & (uncertain | nearness.folded(dot(gap, gap), dot(at_rest, at_rest)));
  }
};

}  // namespace turgor::cloth

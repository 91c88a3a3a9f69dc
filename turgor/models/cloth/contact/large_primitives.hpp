// Filters for contacts of large primitives: vertices near a large triangle and edges near a large edge that
// are not simply neighbors in a flat sheet. They process sixteen candidates at once (T = Lanes) or one (T =
// Real), and are conservative: what passes is tested one by one (large_primitive_kernels.hpp). In a sheet
// without folds hardly anything passes.
#pragma once

#include <cmath>

#include "turgor/models/cloth/model/sheet_view.hpp"

namespace turgor::cloth {

/// Ratio of distance in space to distance along the sheet above which the sheet counts as flat.
inline constexpr Real kStraight = Real(0.9);

/// One bit for each value below b.
TURGOR_HD inline unsigned bits_below(Real a, Real b) { return a < b ? 1 : 0; }
inline unsigned bits_below(Lanes a, Real b) { return lanes_below(a, b); }

/// Distances of a contact.
struct ContactDistances {
  Real reach = 0, thickness = 0;  // [m]

  /// Bits of folded pairs, from their squared distances in space and along the sheet at rest.
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

/// Corner of a triangle, and the vectors to the other two corners.
struct Corner {
  Vec3 at, p, q;
};

/// Filter of vertices near a triangle.
struct NearTriangle {
  ContactDistances distances;
  Vec3 low, high;    // bounds of the search region
  Corner now, rest;  // [m]

  template <class T>
  TURGOR_HD unsigned passes(const Three<T>& point, const Three<T>& point_rest) const {
    // box test
    const unsigned bits = bits_inside<T>(low, high, point);
    if (bits == 0) return 0;
    const Vec3 p = now.p, q = now.q, side = q - p;
    const Real pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), determinant = pp * qq - pq * pq;
    if (!(determinant > Real(1e-3) * pp * qq)) return bits;  // sliver: its nearest point is uncertain
    // barycentric coordinates
    const Three<T> d = minus<T>(point, now.at);
    const T dp = along<T>(d, p), dq = along<T>(d, q);
    const T zero = all_of<T>(0), one = all_of<T>(1);
    const auto between = [&](T t) { return smaller(larger(t, zero), one); };
    // Nearest point inside the triangle, or on one of its sides.
    T v = (dp * qq - dq * pq) * (1 / determinant), w = (dq * pp - dp * pq) * (1 / determinant);
    const T outside = larger(larger(-v, -w), v + w - 1);
    const Three<T> gap = off<T>(d, v, p, w, q);
    T least2 = outside > zero ? all_of<T>(INFINITY) : dot(gap, gap);
    const auto take = [&](T to_p, T to_q) {
      const Three<T> offset = off<T>(d, to_p, p, to_q, q);
      const T apart2 = dot(offset, offset);
      v = apart2 < least2 ? to_p : v, w = apart2 < least2 ? to_q : w, least2 = smaller(apart2, least2);
    };
    const T along_side = between((along<T>(d, side) - dot(p, side)) * (1 / dot(side, side)));
    take(between(dp * (1 / pp)), zero);
    take(zero, between(dq * (1 / qq)));
    take(1 - along_side, along_side);
    // distance along the sheet
    const Three<T> at_rest = off<T>(minus<T>(point_rest, rest.at), v, rest.p, w, rest.q);
    return bits & distances.folded(least2, dot(at_rest, at_rest));
  }
};

/// Edge as a point and a vector.
struct Segment {
  Vec3 from, p;
};
/// Filter of edges whose nearest points to an edge are inside both. Rounding lets some others pass.
struct NearEdge {
  ContactDistances distances;
  Vec3 low, high;  // bounds of the search region for midpoints
  Segment now, rest;

  /// Candidates by midpoint and vector, now and at rest.
  template <class T>
  TURGOR_HD unsigned passes(const Three<T>& middle, const Three<T>& q, const Three<T>& middle_rest,
                            const Three<T>& q_rest) const {
    constexpr Real kSlack = Real(1e-3), kParallel = Real(5e-7), kUncertain = Real(1e-3);
    // box test
    const unsigned bits = bits_inside<T>(low, high, middle);
    if (bits == 0) return 0;
    // parameters of the nearest points
    const Vec3 p = now.p;
    const Three<T> d = minus<T>(middle - q * all_of<T>(0.5f), now.from);
    const T pq = along<T>(q, p), qq = dot(q, q), dp = along<T>(d, p), dq = dot(d, q);
    const T product = qq * dot(p, p), determinant = product - pq * pq;
    const T ds = dp * qq - dq * pq, dt = dp * pq - dq * dot(p, p);
    const T beyond = larger(larger(-ds, ds - determinant), larger(-dt, dt - determinant));
    const unsigned collide = bits & bits_below(beyond - determinant * kSlack, 0) &
                             bits_below(product * kParallel - determinant, 0);
    if (collide == 0) return 0;
    // distances in space and along the sheet
    const T s = ds / determinant, t = dt / determinant;
    const Three<T> gap = off<T>(d + q * t, s, p);
    const Three<T> at_rest = off<T>(minus<T>(middle_rest + q_rest * (t - 0.5f), rest.from), s, rest.p);
    const unsigned uncertain = bits_below(determinant - product * kUncertain, 0);
    return collide & (uncertain | distances.folded(dot(gap, gap), dot(at_rest, at_rest)));
  }
};

}  // namespace turgor::cloth

// Kernels of vertex–triangle and edge–edge contacts of large primitives, for host and device. Candidates have
// passed the filters of large_primitives.hpp.
#pragma once

#include "turgor/geometry/triangle_point.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/large_primitives.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Smallest distance of two points at distance `along` in the sheet: a sheet that turns around in a half
/// circle of diameter θ has them θ sin(along/θ) apart. 0: they are neighbors and have no contact.
TURGOR_HD inline Real least_distance(Real along, Real thickness) {
  constexpr Real kTurn = Real(1.5707963);  // beyond it, points may face each other
  const Real turns = along / thickness;
  return turns < 1 ? 0 : turns < kTurn ? thickness * std::sin(turns) : thickness;
}

/// Parameters of the nearest points of two segments a + s·p and b + t·q. False: one of them is an end, which
/// vertex contacts cover.
TURGOR_HD inline bool nearest_inside(Vec3 a, Vec3 p, Vec3 b, Vec3 q, Real& s, Real& t) {
  const Vec3 d = b - a;
  const Real pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), dp = dot(d, p), dq = dot(d, q);
  const Real determinant = pp * qq - pq * pq;
  if (!(determinant > Real(1e-6) * pp * qq)) return false;
  s = (dp * qq - dq * pq) / determinant, t = (dp * pq - dq * pp) / determinant;
  return s > 0 && s < 1 && t > 0 && t < 1;
}

/// triangles or edges that share one neighborhood on a CPU
constexpr std::size_t kLargeBlock = 16;

/// Axis-aligned box in single precision.
struct Range {
  Vec3 low, high;  // [m]
};
TURGOR_HD inline Range joined(const Range& a, const Range& b) {
  return {min(a.low, b.low), max(a.high, b.high)};
}

/// Cloth with large primitives at the beginning of a step.
struct LargeView {
  ConstVectorsView x, v, change, x_rest;
  ContactsView old;
  Real thickness, friction, reach, dt;
  ContactPhase phase;

  TURGOR_HD Vec3 at(int i) const { return x[std::size_t(i)]; }
  TURGOR_HD Vec3 at_rest(int i) const { return x_rest[std::size_t(i)]; }
  TURGOR_HD ContactDistances distances() const { return {reach, thickness}; }

  /// Tests a contact from its vertices and weights, and fills in the rest. False: it is not near, and was
  /// not.
  TURGOR_HD bool make_contact(Contact& c) const {
    Vec3 d, along_rest;
    Group side[2];  // weights above and below 0
    // mean positions and velocities of both sides
    for (std::size_t k = 0; k < 4; k++) {
      const auto i = std::size_t(c.vertex[k]);
      Group& mine = side[c.weight[k] < 0];
      const Real w = std::abs(c.weight[k]);
      d += x[i] * c.weight[k], along_rest += x_rest[i] * c.weight[k];
      mine.v += v[i] * w, mine.change += change[i] * w;
      mine.touches = mine.touches || old.touches(c.vertex[k]);
    }
    // distance, minimal distance and fold test
    Real distance = norm(d);
    const Real along = norm(along_rest), least = least_distance(along, thickness);
    if (!(distance < reach) || !(distance > 0) || least == 0 || distance > kStraight * along) return false;
    // normal, with the side of the step before
    c.normal = d / distance;
    const Contact* before = find_previous(old, c);
    if (before && dot(before->normal, c.normal) < 0) c.normal = -c.normal, distance = -distance;
    if (!forms_contact(c.normal, before, phase, side[0], side[1], distance, least, dt)) return false;
    // gap and warm start
    c.plane = least, c.gap = distance - least;
    c.friction = friction;
    if (before)
      c.impulse = before->impulse * before->warm_start,
      c.friction_impulse = before->friction_impulse * before->warm_start;
    return true;
  }

  TURGOR_HD Range around(Int3 t) const {
    const Vec3 a = at(t.x), b = at(t.y), c = at(t.z), margin{reach, reach, reach};
    return {min(a, min(b, c)) - margin, max(a, max(b, c)) + margin};
  }
  /// Bounds of the midpoints of edges near this one. `longest_half` is half of the longest edge.
  TURGOR_HD Range around(const std::array<int, 2>& ends, Real longest_half) const {
    const Vec3 a = at(ends[0]), b = at(ends[1]);
    const Real r = Real(1.01) * (reach + longest_half);
    return {min(a, b) - Vec3{r, r, r}, max(a, b) + Vec3{r, r, r}};
  }

  TURGOR_HD NearTriangle filter(Int3 t) const {
    const Vec3 a = at(t.x);
    const Range range = around(t);
    return {distances(),
            range.low,
            range.high,
            {a, at(t.y) - a, at(t.z) - a},
            {at_rest(t.x), at_rest(t.y) - at_rest(t.x), at_rest(t.z) - at_rest(t.x)}};
  }
  /// Tests a triangle and a vertex that passed the filter.
  TURGOR_HD bool touch(Int3 t, int i, Contact& contact) const {
    if (i == t.x || i == t.y || i == t.z) return false;
    const TrianglePoint nearest =
        nearest_on_triangle(Vec3d(at(i)), Vec3d(at(t.x)), Vec3d(at(t.y)), Vec3d(at(t.z)));
    const Vec3 w(nearest.weights);
    if (nearest.distance >= double(reach) || w.x == 1 || w.y == 1 || w.z == 1) return false;
    contact.vertex = {i, t.x, t.y, t.z}, contact.weight = {1, -w.x, -w.y, -w.z};
    return make_contact(contact);
  }

  TURGOR_HD NearEdge filter(const std::array<int, 2>& ends, Real longest_half) const {
    const Vec3 a = at(ends[0]), rest = at_rest(ends[0]);
    const Range range = around(ends, longest_half);
    return {distances(), range.low, range.high, {a, at(ends[1]) - a}, {rest, at_rest(ends[1]) - rest}};
  }
  /// Tests two edges of which the other passed the filter.
  TURGOR_HD bool touch(const std::array<int, 2>& one, const std::array<int, 2>& other,
                       Contact& contact) const {
    const int a = one[0], b = one[1], c = other[0], d = other[1];
    if (c == a || c == b || d == a || d == b) return false;
    Real s, t;
    if (!nearest_inside(at(a), at(b) - at(a), at(c), at(d) - at(c), s, t)) return false;
    contact.vertex = {a, b, c, d}, contact.weight = {1 - s, s, t - 1, -t};
    return make_contact(contact);
  }
};
LargeView large_view(const Model& model, const State& state, ContactPhase phase, Real reach, double dt);

}  // namespace turgor::cloth

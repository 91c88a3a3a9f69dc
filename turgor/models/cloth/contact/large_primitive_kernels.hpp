// Kernels of vertex–triangle and edge–edge contacts of large primitives, for host and device. Candidates have
// passed the filters of large_primitives.hpp.
#pragma once

#include "turgor/geometry/triangle_point.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/large_primitives.hpp"
#include "turgor/models/cloth/contact/normal_cones.hpp"
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

/// Large triangles and edges of a model, with the corners around them (LargePrimitives).
struct LargeMesh {
  const Int3 *triangles, *across;
  const std::array<int, 2>*edges, *facing;
};

/// Cloth with large primitives at the beginning of a step.
struct LargeView {
  LargeMesh mesh;
  ConesView cones;
  ConstVectorsView x, v, change, x_rest;
  ContactsView old;
  Real thickness, friction, reach, dt;
  ContactPhase phase;

  TURGOR_HD Vec3 at(int i) const { return x[std::size_t(i)]; }
  TURGOR_HD Vec3 at_rest(int i) const { return x_rest[std::size_t(i)]; }
  TURGOR_HD ContactDistances distances() const { return {reach, thickness}; }

  /// Tests a contact from its vertices and weights, and fills in the rest. `other` is a second choice for the
  /// normal, if not 0. False: the contact is not near, and was not.
  TURGOR_HD bool make_contact(Contact& c, Vec3 other = {}) const {
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
    const Real distance = norm(d), along = norm(along_rest), least = least_distance(along, thickness);
    if (!(distance < reach) || !(distance > 0) || least == 0 || distance > kStraight * along) return false;
    // normal, with the side of the step before
    c.normal = slower_normal(d / distance, other, side);
    const Contact* before = find_previous(old, c);
    if (before && dot(before->normal, c.normal) < 0) c.normal = -c.normal;
    const Real height = dot(d, c.normal);
    if (!forms_contact(c.normal, before, phase, side[0], side[1], height, least, dt)) return false;
    // gap and warm start
    c.plane = corrected_distance(before, phase, height, least, thickness), c.gap = height - least;
    c.friction = friction;
    if (before)
      c.impulse = before->impulse * before->warm_start,
      c.friction_impulse = before->friction_impulse * before->warm_start;
    return true;
  }
  /// One of two similar normals, along which the sides approach less: sheets slide along the flatter of
  /// them.
  TURGOR_HD Vec3 slower_normal(Vec3 normal, Vec3 other, const Group (&side)[2]) const {
    constexpr Real kSimilar = Real(0.8);  // cosine
    const Real size = norm(other);
    if (!(dot(other, normal) > kSimilar * size)) return normal;
    other *= 1 / size;
    return approach(side[0], side[1], other, dt) < approach(side[0], side[1], normal, dt) ? other : normal;
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
  /// Tests whether the nearest point `q` of triangle n, on the side that faces `corner`, is the nearest of
  /// its sheet in this direction. The triangle with the lower corner has the contact of both.
  TURGOR_HD bool side_has(std::size_t n, int corner, Vec3 q, Vec3 direction) const {
    const Int3 t = mesh.triangles[n];
    const int beyond = mesh.across[n][corner];
    if (beyond >= 0 && beyond < t[corner]) return false;
    const Vec3 edge = at(t[(corner + 2) % 3]) - at(t[(corner + 1) % 3]);
    return cones.edge_has(q, edge, beyond, direction, kConeMargin);
  }
  /// Tests a triangle and a vertex that passed the filter. Corners of the triangle have contacts of two
  /// vertices. A vertex whose cone is not toward the triangle may still come down on it, so this contact is
  /// kept with the choice of a normal in that cone.
  TURGOR_HD bool touch_triangle(std::size_t n, int i, Contact& contact) const {
    const Int3 t = mesh.triangles[n];
    if (i == t.x || i == t.y || i == t.z) return false;
    // nearest point
    const TrianglePoint nearest =
        nearest_on_triangle(Vec3d(at(i)), Vec3d(at(t.x)), Vec3d(at(t.y)), Vec3d(at(t.z)));
    const Vec3 w(nearest.weights), q(nearest.position), direction = at(i) - q;
    if (nearest.distance >= double(reach) || w.x == 1 || w.y == 1 || w.z == 1) return false;
    contact.vertex = {i, t.x, t.y, t.z}, contact.weight = {1, -w.x, -w.y, -w.z};
    // normal cones of a side and of the vertex
    const bool is_inside = w.x > 0 && w.y > 0 && w.z > 0;
    for (int k = 0; k < 3; k++)
      if (w[k] == 0 && !side_has(n, k, q, direction)) return false;
    if (cones.vertex_has(i, -direction)) return make_contact(contact);
    return is_inside && make_contact(contact, -cones.projected(i, -direction));
  }

  TURGOR_HD NearEdge filter(const std::array<int, 2>& ends, Real longest_half) const {
    const Vec3 a = at(ends[0]), rest = at_rest(ends[0]);
    const Range range = around(ends, longest_half);
    return {distances(), range.low, range.high, {a, at(ends[1]) - a}, {rest, at_rest(ends[1]) - rest}};
  }
  /// Tests whether a direction from the point `q` of edge e is inside its normal cone.
  TURGOR_HD bool edge_has(std::size_t e, Vec3 q, Vec3 direction) const {
    const Vec3 edge = at(mesh.edges[e][1]) - at(mesh.edges[e][0]);
    for (const int corner : mesh.facing[e])
      if (!cones.edge_has(q, edge, corner, direction, -kEdgeDepth)) return false;
    return true;
  }
  /// Tests whether the cone of edge e may have directions inside it: its triangles are folded, or it is a
  /// rim. With unit vectors t₁ and t₂ into both, a direction d inside has d·(t₁ + t₂) < −2 kEdgeDepth.
  TURGOR_HD bool is_sharp(std::size_t e) const {
    constexpr Real kRounding = Real(0.95);
    const Vec3 from = at(mesh.edges[e][0]), edge = at(mesh.edges[e][1]) - from;
    Vec3 sum;
    for (const int corner : mesh.facing[e]) {
      if (corner < 0) return true;
      const Vec3 side = at(corner) - from;
      sum += normalized(side - edge * (dot(side, edge) / dot(edge, edge)));
    }
    return norm(sum) > 2 * kRounding * kEdgeDepth;
  }
  /// Tests two edges of which the other passed the filter.
  TURGOR_HD bool touch_edges(std::size_t one, std::size_t other, Contact& contact) const {
    const auto [a, b] = mesh.edges[one];
    const auto [c, d] = mesh.edges[other];
    if (c == a || c == b || d == a || d == b) return false;
    Real s, t;
    if (!nearest_inside(at(a), at(b) - at(a), at(c), at(d) - at(c), s, t)) return false;
    const Vec3 p = at(a) + (at(b) - at(a)) * s, q = at(c) + (at(d) - at(c)) * t;
    if (!edge_has(one, p, q - p) || !edge_has(other, q, p - q)) return false;
    contact.vertex = {a, b, c, d}, contact.weight = {1 - s, s, t - 1, -t};
    return make_contact(contact);
  }
};
LargeView large_view(const Model& model, const State& state, ContactPhase phase, Real reach, double dt);

}  // namespace turgor::cloth

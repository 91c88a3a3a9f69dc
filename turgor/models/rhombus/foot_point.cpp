#include "turgor/models/rhombus/foot_point.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::rhombus {

namespace {

constexpr int kLongestWalk = 200;  // triangles a search
constexpr double kOutside = 1e-10;

/// Unknowns: weights of b and c, and the height in units of the interpolated normal.
struct ProjectionUnknowns {
  double b = 0, c = 0, h = 0;
};

struct CornerNormals {
  Vec3d a, b, c;
};

CornerNormals normals_of(const Surface& s, int triangle) {
  const Int3 t = s.triangles[std::size_t(triangle)];
  return {s.normals[std::size_t(t.x)], s.normals[std::size_t(t.y)], s.normals[std::size_t(t.z)]};
}

/// Newton's method for p(b, c) + h n(b, c) = point. False when it does not converge.
bool solve_phong_projection(const Surface& s, int triangle, Vec3d point, ProjectionUnknowns& unknowns) {
  const Vec3d x = corner_position(s, triangle, 0), e = corner_position(s, triangle, 1) - x,
              f = corner_position(s, triangle, 2) - x;
  const auto [na, nb, nc] = normals_of(s, triangle);
  auto& [b, c, h] = unknowns;
  const double flat = norm(cross(e, f));
  for (int i = 0; i < 12; i++) {
    // residual and Jacobian
    const Vec3d n = na + (nb - na) * b + (nc - na) * c;
    const Vec3d residual = point - (x + e * b + f * c + n * h);
    const Vec3d jb = e + (nb - na) * h, jc = f + (nc - na) * h;
    const Vec3d across = cross(jb, jc);
    const double volume = dot(across, n);
    if (!(volume > 0.01 * flat)) return false;  // normals meet below the surface
    // Newton step by Cramer's rule
    const double db = dot(residual, cross(jc, n)) / volume, dc = dot(residual, cross(n, jb)) / volume;
    b += db, c += dc, h += dot(residual, across) / volume;
    if (std::abs(db) + std::abs(dc) < 1e-14) return true;
    if (!(std::abs(b) + std::abs(c) < 1e3)) return false;
  }
  return std::abs(b) + std::abs(c) < 1e3;
}

FootPoint foot_point_in(const Surface& s, int triangle, Vec3d weights, Vec3d point) {
  TURGOR_CHECK(is_index(triangle, s.triangles.size()) && sums_to_one(weights),
               "a foot point is in a triangle, and its weights sum to one");
  const auto [na, nb, nc] = normals_of(s, triangle);
  FootPoint foot;
  foot.at.triangle = triangle, foot.at.weights = weights;
  foot.at.position = corner_position(s, triangle, 0) * weights.x +
                     corner_position(s, triangle, 1) * weights.y +
                     corner_position(s, triangle, 2) * weights.z;
  foot.normal = normalized(na * weights.x + nb * weights.y + nc * weights.z);
  foot.height = dot(point - foot.at.position, foot.normal);
  return foot;
}

/// Clamps weights to the triangle and normalizes them.
Vec3d clamp_weights(Vec3d w) {
  w = max(w, Vec3d{});
  TURGOR_CHECK(w.x + w.y + w.z > 0, "at least one weight is positive");
  return w / (w.x + w.y + w.z);
}

/// The same point of an edge, in the weights of the triangle beyond it.
struct BeyondEdge {
  int triangle = 0;
  Vec3d weights;
};
BeyondEdge cross_edge(const Surface& s, int triangle, int side, Vec3d weights) {
  const int beyond = s.across[std::size_t(3 * triangle + side)];
  TURGOR_CHECK(beyond >= 0, "every side of a closed surface has a neighbor");
  BeyondEdge next{beyond / 3, {}};
  const int other = beyond % 3;  // traversed in the opposite direction
  weights[(side + 2) % 3] = 0;
  weights = clamp_weights(weights);
  next.weights[other] = weights[(side + 1) % 3], next.weights[(other + 1) % 3] = weights[side];
  return next;
}

}  // namespace

FootPoint find_foot_point(const Surface& surface, const TriangleTree& tree, Vec3d point) {
  const TrianglePoint at = nearest_point(tree, point);
  return follow_foot_point(surface, foot_point_in(surface, at.triangle, at.weights, point), point);
}

FootPoint follow_foot_point(const Surface& surface, const FootPoint& before, Vec3d point) {
  int triangle = before.at.triangle, came_from = -1;
  Vec3d weights = before.at.weights;
  double height = dot(point - before.at.position, before.normal);
  for (int i = 0; i < kLongestWalk; i++) {
    // project within the triangle
    ProjectionUnknowns unknowns{weights.y, weights.z, height};
    if (!solve_phong_projection(surface, triangle, point, unknowns)) break;
    const Vec3d found{1 - unknowns.b - unknowns.c, unknowns.b, unknowns.c};
    // inside: done
    const int lowest = found.x <= found.y ? (found.x <= found.z ? 0 : 2) : (found.y <= found.z ? 1 : 2);
    if (found[lowest] >= -kOutside) return foot_point_in(surface, triangle, clamp_weights(found), point);
    // otherwise continue beyond the edge of the lowest weight
    const BeyondEdge next = cross_edge(surface, triangle, (lowest + 1) % 3, found);
    if (next.triangle == came_from) return foot_point_in(surface, triangle, clamp_weights(found), point);
    came_from = triangle, triangle = next.triangle, weights = next.weights, height = unknowns.h;
  }
  return foot_point_in(surface, before.at.triangle, before.at.weights, point);
}

}  // namespace turgor::rhombus

#include "turgor/models/rhombus/foot.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::rhombus {

namespace {

constexpr int kLongestWalk = 200;  // triangles in one tick
constexpr double kOutside = 1e-10;

/// Weights of b and c, and the height in units of the interpolated normal.
struct FootUnknowns {
  double b = 0, c = 0, h = 0;
};

struct CornerNormals {
  Vec3d a, b, c;
};

CornerNormals normals_of(const Surface& s, int triangle) {
  const Int3 t = s.triangles[std::size_t(triangle)];
  return {s.normals[std::size_t(t.x)], s.normals[std::size_t(t.y)], s.normals[std::size_t(t.z)]};
}

/// Newton on p(b, c) + h n(b, c) = point. False when it does not settle.
bool settle(const Surface& s, int triangle, Vec3d point, FootUnknowns& unknowns) {
  const Vec3d x = corner_place(s, triangle, 0), e = corner_place(s, triangle, 1) - x,
              f = corner_place(s, triangle, 2) - x;
  const auto [na, nb, nc] = normals_of(s, triangle);
  auto& [b, c, h] = unknowns;
  const double flat = norm(cross(e, f));
  for (int i = 0; i < 12; i++) {
    const Vec3d n = na + (nb - na) * b + (nc - na) * c;
    const Vec3d missing = point - (x + e * b + f * c + n * h);
    const Vec3d jb = e + (nb - na) * h, jc = f + (nc - na) * h;
    const Vec3d across = cross(jb, jc);
    const double volume = dot(across, n);
    if (!(volume > 0.01 * flat)) return false;  // normals come together below
    const double db = dot(missing, cross(jc, n)) / volume, dc = dot(missing, cross(n, jb)) / volume;
    b += db, c += dc, h += dot(missing, across) / volume;
    if (std::abs(db) + std::abs(dc) < 1e-14) return true;
    if (!(std::abs(b) + std::abs(c) < 1e3)) return false;
  }
  return std::abs(b) + std::abs(c) < 1e3;
}

Foot foot_in(const Surface& s, int triangle, Vec3d weights, Vec3d point) {
  const auto [na, nb, nc] = normals_of(s, triangle);
  Foot foot;
  foot.at.triangle = triangle, foot.at.weights = weights;
  foot.at.place = corner_place(s, triangle, 0) * weights.x + corner_place(s, triangle, 1) * weights.y +
                  corner_place(s, triangle, 2) * weights.z;
  foot.normal = normalized(na * weights.x + nb * weights.y + nc * weights.z);
  foot.height = dot(point - foot.at.place, foot.normal);
  return foot;
}

/// The nearest weights of which none is negative.
Vec3d inside(Vec3d w) {
  w = max(w, Vec3d{});
  return w / (w.x + w.y + w.z);
}

/// The same place of an edge, seen from the triangle beyond it.
struct BeyondEdge {
  int triangle = 0;
  Vec3d weights;
};
BeyondEdge cross_edge(const Surface& s, int triangle, int side, Vec3d weights) {
  const int beyond = s.across[std::size_t(3 * triangle + side)];
  BeyondEdge next{beyond / 3, {}};
  const int other = beyond % 3;  // runs the other way
  weights[(side + 2) % 3] = 0;
  weights = inside(weights);
  next.weights[other] = weights[(side + 1) % 3], next.weights[(other + 1) % 3] = weights[side];
  return next;
}

}  // namespace

Foot find_foot(const Surface& surface, const TriangleTree& tree, Vec3d point) {
  const TrianglePoint at = nearest_point(tree, point);
  return follow_foot(surface, foot_in(surface, at.triangle, at.weights, point), point);
}

Foot follow_foot(const Surface& surface, const Foot& before, Vec3d point) {
  int triangle = before.at.triangle, came_from = -1;
  Vec3d weights = before.at.weights;
  double height = dot(point - before.at.place, before.normal);
  for (int i = 0; i < kLongestWalk; i++) {
    FootUnknowns unknowns{weights.y, weights.z, height};
    if (!settle(surface, triangle, point, unknowns)) break;
    const Vec3d found{1 - unknowns.b - unknowns.c, unknowns.b, unknowns.c};
    const int lowest = found.x <= found.y ? (found.x <= found.z ? 0 : 2) : (found.y <= found.z ? 1 : 2);
    if (found[lowest] >= -kOutside) return foot_in(surface, triangle, inside(found), point);
    const BeyondEdge next = cross_edge(surface, triangle, (lowest + 1) % 3, found);
    if (next.triangle == came_from) return foot_in(surface, triangle, inside(found), point);
    came_from = triangle, triangle = next.triangle, weights = next.weights, height = unknowns.h;
  }
  return foot_in(surface, before.at.triangle, before.at.weights, point);
}

}  // namespace turgor::rhombus

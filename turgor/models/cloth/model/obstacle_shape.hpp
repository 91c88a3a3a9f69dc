// Obstacle shapes of a cloth, as plain pointers for host and device: signed distance, normal and velocity of
// the nearest surface point for a vertex and for a triangle.
#pragma once

#include <array>
#include <cstdint>

#include "turgor/geometry/box_tree.hpp"
#include "turgor/geometry/pose.hpp"
#include "turgor/geometry/shape_distance.hpp"
#include "turgor/geometry/triangle_point.hpp"

namespace turgor::cloth {

/// Nearest point of an obstacle's surface.
struct SurfacePoint {
  Real distance = 0;  // negative inside [m]
  Vec3 normal;        // unit, outward
  Vec3 velocity;      // of the surface at that point [m/s]
};

/// Half-space below a plane.
struct PlaneShape {
  Vec3 normal;      // unit
  Real height = 0;  // of the plane along the normal [m]

  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
    found = {.distance = dot(normal, x) - height, .normal = normal, .velocity = {}};
    return found.distance < reach;
  }
};

/// Triangle surface whose vertices move (MovingSurface).
struct SurfaceShape {
  BoxTreeView boxes;                // of the triangles
  const Vec3d* vertices = nullptr;  // [m]
  const Int3* triangles = nullptr;
  const Vec3 *normals = nullptr, *velocities = nullptr;  // of the vertices; null velocities: at rest [m/s]
  double depth = 0;                                      // vertices deeper below the surface are ignored [m]

  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
    // nearest triangle
    const double far = double(reach) > depth ? double(reach) : depth;
    TrianglePoint at;
    const int item = nearest_item(boxes, Vec3d(x), far * far, [&](int t, double best) {
      const Int3 c = triangles[t];
      TrianglePoint p = nearest_on_triangle(Vec3d(x), vertices[c.x], vertices[c.y], vertices[c.z]);
      const double d2 = p.distance * p.distance;
      if (d2 < best) p.triangle = t, at = p;
      return d2;
    });
    if (item < 0) return false;
    // interpolated normal, which decides the side
    const Int3 t = triangles[at.triangle];
    Vec3d normal;
    for (int k = 0; k < 3; k++) normal += Vec3d(normals[t[k]]) * at.weights[k];
    const Vec3d away = Vec3d(x) - at.position;
    const double side = dot(away, normal) >= 0 ? 1 : -1;
    const bool is_on_it = !(at.distance > 1e-9 * far);
    // signed distance, normal and velocity
    found.distance = Real(side * at.distance);
    found.normal = Vec3(is_on_it ? normalized(normal) : normalized(away) * side);
    found.velocity = {};
    if (velocities != nullptr)
      for (int k = 0; k < 3; k++) found.velocity += velocities[t[k]] * Real(at.weights[k]);
    return found.distance < reach;
  }
};

/// Rigid shape that moves from one pose to another in a step: a ball, a rod, or a distance grid. A tool is
/// also tested against triangles, so it cannot pass between vertices. The test points are its tips: centers
/// of balls that fill it, or samples of its surface.
struct RigidShape {
  Pose from, to;
  double dt = 1;                // [s]
  double radius = 0;            // of a ball or a rod [m]
  double half_length = 0;       // half length of a rod's axis, along z; 0 = a ball [m]
  DistanceGrid grid;            // used if it has nodes
  double bound = 0;             // radius of a ball around its origin that contains the shape [m]
  int tip_count = 0;            // 0 = no tool
  const Vec3d* tips = nullptr;  // of a grid; null: balls along the rod [m]
  double too_small = 0;         // triangles with shorter edges only are tested at their corners [m]

  TURGOR_HD ShapeDistance distance(Vec3d x) const {
    const Vec3d point = to_tool(from, x);
    ShapeDistance d = grid.nodes ? grid_distance(grid, point) : rod_distance(radius, half_length, point);
    d.normal = from.axes * d.normal;
    return d;
  }
  TURGOR_HD Vec3d tip(int n) const { return tips ? tips[n] : rod_ball(half_length, tip_count, n); }
  /// Surface point at a distance sample; its velocity is that of the rigid motion.
  TURGOR_HD SurfacePoint surface_at(const ShapeDistance& at, Vec3d point) const {
    const Vec3d body = to_tool(from, point - at.normal * at.distance);
    return {.distance = Real(at.distance),
            .normal = Vec3(at.normal),
            .velocity = Vec3((to_world(to, body) - to_world(from, body)) / dt)};
  }

  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
    const Vec3d point(x), off = point - from.position;
    const double far = bound + double(reach);
    if (dot(off, off) > far * far) return false;
    found = surface_at(distance(point), point);
    return found.distance < reach;
  }
  /// Point of a triangle nearest to the shape, as weights of its corners. False: none within `reach`.
  TURGOR_HD bool nearest_in(Vec3 corner_a, Vec3 corner_b, Vec3 corner_c, Real reach,
                            std::array<Real, 3>& weight, SurfacePoint& found) const {
    // reject small and far triangles
    constexpr int kMostTips = 16;
    const Vec3d a(corner_a), b(corner_b), c(corner_c);
    const double size = std::max(norm(b - a), std::max(norm(c - a), norm(c - b))),
                 far = bound + double(reach) + size;
    const Vec3d off = a - from.position;
    if (size < too_small || dot(off, off) > far * far) return false;
    // nearest of the tips, sixteen at most
    found.distance = reach;
    const int stride = std::max(1, tip_count / kMostTips);
    for (int n = 0; n < tip_count; n += stride) {
      const Vec3d w = closest_weights(to_world(from, tip(n)), a, b, c);
      const Vec3d point = a * w.x + b * w.y + c * w.z;
      const ShapeDistance at = distance(point);
      if (!(Real(at.distance) < found.distance)) continue;
      found = surface_at(at, point);
      weight = {Real(w.x), Real(w.y), Real(w.z)};
    }
    return found.distance < reach;
  }
};

/// Shape of an obstacle: one of the three, by `kind`.
struct ObstacleShape {
  enum class Kind : std::uint8_t { kPlane, kSurface, kRigid };

  Kind kind = Kind::kPlane;
  PlaneShape plane;
  SurfaceShape surface;
  RigidShape rigid;

  /// Finds the nearest surface point to x. False: it is farther than `reach`.
  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
    if (kind == Kind::kPlane) return plane.nearest(x, reach, found);
    if (kind == Kind::kSurface) return surface.nearest(x, reach, found);
    return rigid.nearest(x, reach, found);
  }
  /// True for tools, which are tested against triangles too.
  TURGOR_HD bool may_pass_between() const { return rigid.tip_count > 0; }
};

/// Obstacle: shape and contact parameters.
struct ObstacleView {
  ObstacleShape shape;
  double speed = 0;       // upper bound of the speed of its surface [m/s]
  double friction = 0.3;  // Coulomb's coefficient [1]
  double gap = 0.002;     // distance that the cloth keeps from the surface [m]
  double compliance = 0;  // displacement per total contact force where cloth is squeezed between this
                          // obstacle and another; 0 = rigid [m/N]
};

}  // namespace turgor::cloth

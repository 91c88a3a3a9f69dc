// What a cloth must stay out of, as plain pointers, here or on a GPU: how far a vertex is from it, and a
// triangle between its vertices.
#pragma once

#include <array>
#include <cstdint>

#include "turgor/geometry/box_tree.hpp"
#include "turgor/geometry/pose.hpp"
#include "turgor/geometry/shape_distance.hpp"
#include "turgor/geometry/triangle_point.hpp"

namespace turgor::cloth {

/// What an obstacle says about the place of its surface that is nearest to a vertex.
struct SurfacePoint {
  Real distance = 0;  // negative inside [m]
  Vec3 normal;        // unit, outward
  Vec3 velocity;      // of the surface there [m/s]
};

/// Everything on the far side of a plane.
struct PlaneShape {
  Vec3 normal;      // unit
  Real height = 0;  // of the plane along it [m]

  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
    found = {.distance = dot(normal, x) - height, .normal = normal, .velocity = {}};
    return found.distance < reach;
  }
};

/// A surface of triangles that moves with its vertices (MovingSurface).
struct SurfaceShape {
  BoxTreeView boxes;                // of the triangles
  const Vec3d* vertices = nullptr;  // [m]
  const Int3* triangles = nullptr;
  const Vec3 *normals = nullptr, *velocities = nullptr;  // of the vertices; no velocities: at rest [m/s]
  double depth = 0;  // vertices deeper below the surface are left alone [m]

  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
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
    const Int3 t = triangles[at.triangle];
    Vec3d normal;
    for (int k = 0; k < 3; k++) normal += Vec3d(normals[t[k]]) * at.weights[k];
    const Vec3d away = Vec3d(x) - at.place;
    const double side = dot(away, normal) >= 0 ? 1 : -1;
    const bool is_on_it = !(at.distance > 1e-9 * far);
    found.distance = Real(side * at.distance);
    found.normal = Vec3(is_on_it ? normalized(normal) : normalized(away) * side);
    found.velocity = {};
    if (velocities != nullptr)
      for (int k = 0; k < 3; k++) found.velocity += velocities[t[k]] * Real(at.weights[k]);
    return found.distance < reach;
  }
};

/// A rigid shape at the beginning of a step in which it goes from one pose to another: a ball, a rod, or
/// distances on a grid. As a tool it cannot pass between vertices either, however small it is: its tips,
/// centres of balls that fill it or places of its surface, are looked at against triangles.
struct RigidShape {
  Pose from, to;
  double dt = 1;                // [s]
  double radius = 0;            // of a ball or a rod [m]
  double half_length = 0;       // of a rod's middle line, on the z axis; 0 = a ball [m]
  DistanceGrid grid;            // instead, where it has nodes
  double bound = 0;             // no point of it is farther from its origin [m]
  int tip_count = 0;            // 0 = no tool
  const Vec3d* tips = nullptr;  // of a grid [m]
  double too_small = 0;         // triangles with no longer edge have corners that are enough [m]

  TURGOR_HD ShapeDistance distance(Vec3d x) const {
    const Vec3d place = to_tool(from, x);
    ShapeDistance d = grid.nodes ? grid_distance(grid, place) : rod_distance(radius, half_length, place);
    d.normal = from.axes * d.normal;
    return d;
  }
  TURGOR_HD Vec3d tip(int n) const { return tips ? tips[n] : rod_ball(half_length, tip_count, n); }
  /// The surface moves with the shape.
  TURGOR_HD SurfacePoint surface_at(const ShapeDistance& at, Vec3d place) const {
    const Vec3d body = to_tool(from, place - at.normal * at.distance);
    return {.distance = Real(at.distance),
            .normal = Vec3(at.normal),
            .velocity = Vec3((to_world(to, body) - to_world(from, body)) / dt)};
  }

  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
    const Vec3d place(x), off = place - from.position;
    const double far = bound + double(reach);
    if (dot(off, off) > far * far) return false;
    found = surface_at(distance(place), place);
    return found.distance < reach;
  }
  /// The place of a triangle that it comes nearest to, as weights of its corners.
  TURGOR_HD bool nearest_in(Vec3 corner_a, Vec3 corner_b, Vec3 corner_c, Real reach,
                            std::array<Real, 3>& weight, SurfacePoint& found) const {
    constexpr int kMostTips = 16;
    const Vec3d a(corner_a), b(corner_b), c(corner_c);
    const double size = std::max(norm(b - a), std::max(norm(c - a), norm(c - b))),
                 far = bound + double(reach) + size;
    const Vec3d off = a - from.position;
    if (size < too_small || dot(off, off) > far * far) return false;
    found.distance = reach;
    const int stride = std::max(1, tip_count / kMostTips);
    for (int n = 0; n < tip_count; n += stride) {
      const Vec3d w = closest_weights(to_world(from, tip(n)), a, b, c);
      const Vec3d place = a * w.x + b * w.y + c * w.z;
      const ShapeDistance at = distance(place);
      if (!(Real(at.distance) < found.distance)) continue;
      found = surface_at(at, place);
      weight = {Real(w.x), Real(w.y), Real(w.z)};
    }
    return found.distance < reach;
  }
};

/// One of these.
struct ObstacleShape {
  enum class Kind : std::uint8_t { kPlane, kSurface, kRigid };

  Kind kind = Kind::kPlane;
  PlaneShape plane;
  SurfaceShape surface;
  RigidShape rigid;

  /// Nearest surface to x, or false when it is farther than `reach`.
  TURGOR_HD bool nearest(Vec3 x, Real reach, SurfacePoint& found) const {
    if (kind == Kind::kPlane) return plane.nearest(x, reach, found);
    if (kind == Kind::kSurface) return surface.nearest(x, reach, found);
    return rigid.nearest(x, reach, found);
  }
  /// Is it so small that it could pass between vertices?
  TURGOR_HD bool may_pass_between() const { return rigid.tip_count > 0; }
};

/// Something that the cloth must stay out of.
struct ObstacleView {
  ObstacleShape shape;
  double speed = 0;       // no part of its surface is faster [m/s]
  double friction = 0.3;  // Coulomb's coefficient [1]
  double gap = 0.002;     // the cloth stays this far away [m]
  double compliance = 0;  // how far it gives way where the cloth is pressed between it and another, by the
                          // sum of the force; 0 = it is rigid [m/N]
};

}  // namespace turgor::cloth

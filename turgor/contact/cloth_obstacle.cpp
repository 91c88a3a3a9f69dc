#include "turgor/contact/cloth_obstacle.hpp"

#include <algorithm>

#include "turgor/contact/tick.hpp"

namespace turgor::contact {

namespace {

/// The place of a triangle that a shape comes nearest to.
struct NearestIn {
  const Shape& shape;
  Pose from, to;
  double dt;
  double radius;     // around the shape [m]
  double too_small;  // triangles with no longer edge have corners that are enough [m]

  bool operator()(const std::array<Vec3, 3>& corner, Real reach, std::array<Real, 3>& weight,
                  cloth::SurfacePoint& found) const {
    constexpr int kMostTips = 16;
    const Vec3d a(corner[0]), b(corner[1]), c(corner[2]);
    const double size = std::max({norm(b - a), norm(c - a), norm(c - b)}),
                 far = radius + double(reach) + size;
    const Vec3d off = a - from.position;
    if (size < too_small || dot(off, off) > far * far) return false;
    found.distance = reach;
    const int tips = tip_count(shape), stride = std::max(1, tips / kMostTips);
    for (int n = 0; n < tips; n += stride) {
      const Vec3d w = closest_weights(to_world(from, tip(shape, n)), a, b, c);
      const Vec3d place = a * w.x + b * w.y + c * w.z;
      const ShapeDistance at = distance(shape, from, place);
      if (!(Real(at.distance) < found.distance)) continue;
      const Vec3d body = to_tool(from, place - at.normal * at.distance);
      found = {.distance = Real(at.distance),
               .normal = Vec3(at.normal),
               .velocity = Vec3((to_world(to, body) - to_world(from, body)) / dt)};
      weight = {Real(w.x), Real(w.y), Real(w.z)};
    }
    return found.distance < reach;
  }
};

}  // namespace

cloth::Obstacle cloth_tool(const Shape& shape, const Pose& from, const Pose& to, double dt) {
  constexpr double kSmall = 0.25;  // of the tip's radius: it sinks in between vertices by less than 1 %
  cloth::Obstacle obstacle = cloth_obstacle(shape, from, to, dt);
  obstacle.nearest_in = NearestIn{shape, from, to, dt, bounding_radius(shape), kSmall * tip_radius(shape)};
  obstacle.speed = motion(shape, from, to) / dt;
  return obstacle;
}

cloth::Obstacle cloth_obstacle(const Shape& shape, const Pose& from, const Pose& to, double dt) {
  return {.nearest = [&shape, from, to, dt, radius = bounding_radius(shape)](Vec3 x, Real reach,
                                                                             cloth::SurfacePoint& found) {
    const Vec3d place(x), off = place - from.position;
    const double far = radius + double(reach);
    if (dot(off, off) > far * far) return false;
    const ShapeDistance at = distance(shape, from, place);
    const Vec3d body =
        to_tool(from, place - at.normal * at.distance);  // the surface point moves with the tool
    found = {.distance = Real(at.distance),
             .normal = Vec3(at.normal),
             .velocity = Vec3((to_world(to, body) - to_world(from, body)) / dt)};
    return found.distance < reach;
  }};
}

}  // namespace turgor::contact

#include "turgor/contact/cloth_obstacle.hpp"

namespace turgor::contact {

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

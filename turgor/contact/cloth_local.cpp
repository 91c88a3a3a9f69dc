// The local contact of a tool on a cloth that it kept out of in the last step.
#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/contact/local_stiffness.hpp"
#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::contact {

namespace {

/// The place of the sheet that is nearest to a tool.
struct SheetPlace {
  Vec3d x, normal;                                           // the normal from the sheet at the tool
  double outside = std::numeric_limits<double>::infinity();  // of the tool's shape [m]
  double mass = 0;                                           // that moves when it is pushed there [kg]
};

/// The nearest point of a triangle to the tool's balls, if it is nearer than what was found.
void read_nodes(const cloth::Model& model, const cloth::State& state, Int3 t, const Shape& shape,
                const Pose& pose, SheetPlace& nearest) {
  constexpr int kMostTips = 16;
  const Vec3d a(state.x[std::size_t(t.x)]), b(state.x[std::size_t(t.y)]), c(state.x[std::size_t(t.z)]);
  const int tips = tip_count(shape), stride = std::max(1, tips / kMostTips);
  for (int n = 0; n < tips; n += stride) {
    const Vec3d w = closest_weights(to_world(pose, tip(shape, n)), a, b, c);
    const Vec3d x = a * w.x + b * w.y + c * w.z;
    const ShapeDistance d = distance(shape, pose, x);
    if (d.distance >= nearest.outside) continue;
    const auto m = [&](int v) { return double(model.mass[std::size_t(v)]); };
    const double mobility = w.x * w.x / m(t.x) + w.y * w.y / m(t.y) + w.z * w.z / m(t.z);
    nearest = {x, -d.normal, d.distance, mobility > 0 ? 1 / mobility : 0};
  }
}

SheetPlace nearest_place(const cloth::Model& model, const cloth::State& state, const Shape& shape,
                         const Pose& pose, double reach) {
  const double near = bounding_radius(shape) + reach;
  SheetPlace nearest;
  for (const Int3 t : model.triangles) {
    const Vec3d off = Vec3d(state.x[std::size_t(t.x)]) - pose.position;
    if (dot(off, off) < near * near) read_nodes(model, state, t, shape, pose, nearest);
  }
  return nearest;
}

/// What the cloth's contacts with the tool did in the last step.
struct Push {
  Vec3d force, normal, place;  // of the sheet on the tool; the last two weighted by its pressure [N·s]
  double weight = 0;           // [N·s]
  double mass = 0;             // that it moves [kg]
};
Push push_of(const cloth::State& state, int obstacle, double dt) {
  Push push;
  for (const cloth::Contact& c : state.contacts.list) {
    if (c.obstacle != obstacle || !(c.impulse > 0)) continue;
    push.force += impulse_on_obstacle(c) / dt;
    push.normal -= Vec3d(c.normal * c.impulse);
    push.place += place_of(state, c) * double(c.impulse);
    push.weight += double(c.impulse), push.mass += double(c.mass);
  }
  return push;
}

}  // namespace

LocalContact local_contact(const cloth::Model& model, const cloth::State& state, int obstacle, double gap,
                           const Tool& tool, const Pose& pose, double dt, LocalMemory& memory) {
  LocalContact made{.origin = pose.position, .friction = tool.friction, .reach = 2 * model.mean_edge + gap};
  const Push push = push_of(state, obstacle, dt);
  double mass = push.mass;
  if (push.weight > 0 && norm(push.normal) > 0) {
    made.is_near = true;
    made.force = push.force, made.normal = normalized(push.normal);
    made.arm = push.place / push.weight - made.origin;
  } else {
    const SheetPlace place = nearest_place(model, state, tool.shape, pose, made.reach);
    made.is_near = std::isfinite(place.outside);
    if (made.is_near) made.normal = place.normal, made.arm = place.x - made.origin;
    if (made.is_near) made.gap = std::max(0.0, place.outside - gap);
    mass = place.mass;
  }
  measure_stiffness(mass / (dt * dt), std::numeric_limits<double>::infinity(), memory, made);
  return made;
}

}  // namespace turgor::contact

// Local contact of a tool on a cloth, from the cloth's contacts in the last step.
#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/contact/local_stiffness.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::contact {

namespace {

/// Sheet point nearest to a tool.
struct SheetPoint {
  Vec3d x, normal;                                           // normal from the sheet at the tool
  double outside = std::numeric_limits<double>::infinity();  // of the tool's shape [m]
  double mass = 0;  // effective mass of the sheet for a push there [kg]
};

/// Updates the nearest sheet point by a triangle's nearest points to the tool's balls.
void test_triangle(const cloth::Model& model, const cloth::State& state, Int3 t, const Shape& shape,
                   const Pose& pose, SheetPoint& nearest) {
  TURGOR_CHECK(are_indices(t, state.x.size()), "the corners of a triangle are vertices of the sheet");
  constexpr int kMaxTips = 16;
  const Vec3d a(state.x[std::size_t(t.x)]), b(state.x[std::size_t(t.y)]), c(state.x[std::size_t(t.z)]);
  const int tips = tip_count(shape), stride = std::max(1, tips / kMaxTips);
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

/// Sheet point nearest to the tool among triangles within `reach` of it.
SheetPoint nearest_sheet_point(const cloth::Model& model, const cloth::State& state, const Shape& shape,
                               const Pose& pose, double reach) {
  TURGOR_CHECK(state.x.size() == model.mass.size(), "the positions are on the host while contacts are found");
  const double near = bounding_radius(shape) + reach;
  SheetPoint nearest;
  for (const Int3 t : model.triangles) {
    const Vec3d off = Vec3d(state.x[std::size_t(t.x)]) - pose.position;
    if (dot(off, off) < near * near) test_triangle(model, state, t, shape, pose, nearest);
  }
  return nearest;
}

/// Sum over the cloth's contacts with the tool in the last step.
struct Push {
  Vec3d force, normal, position;  // of the sheet on the tool; the last two weighted by impulse [N·s]
  double weight = 0;              // [N·s]
  double mass = 0;                // effective [kg]
};
Push contact_push(const cloth::State& state, int obstacle, double dt) {
  TURGOR_CHECK(is_step_length(dt), "impulses become forces over a step of positive length");
  Push push;
  for (const cloth::Contact& c : state.contacts.list) {
    if (c.obstacle != obstacle || !(c.impulse > 0)) continue;
    push.force += impulse_on_obstacle(c) / dt;
    push.normal -= Vec3d(c.normal * c.impulse);
    push.position += contact_position(state, c) * double(c.impulse);
    push.weight += double(c.impulse), push.mass += double(c.mass);
  }
  return push;
}

}  // namespace

LocalContact local_contact(const cloth::Model& model, const cloth::State& state, int obstacle, double gap,
                           const Tool& tool, const Pose& pose, double dt, LocalContactHistory& memory) {
  // contact impulses of the last step
  TURGOR_CHECK(obstacle >= 0, "the tool was an obstacle of the step");
  LocalContact contact{
      .origin = pose.position, .friction = tool.friction, .reach = 2 * model.mean_edge + gap};
  const Push push = contact_push(state, obstacle, dt);
  double mass = push.mass;
  // in contact: weighted mean; otherwise: nearest sheet point
  if (push.weight > 0 && norm(push.normal) > 0) {
    contact.is_near = true;
    contact.force = push.force, contact.normal = normalized(push.normal);
    contact.arm = push.position / push.weight - contact.origin;
  } else {
    const SheetPoint nearest = nearest_sheet_point(model, state, tool.shape, pose, contact.reach);
    contact.is_near = std::isfinite(nearest.outside);
    if (contact.is_near) contact.normal = nearest.normal, contact.arm = nearest.x - contact.origin;
    if (contact.is_near) contact.gap = std::max(0.0, nearest.outside - gap);
    mass = nearest.mass;
  }
  // stiffness of an implicit step: m / dt²; the force of an impact ends within the reach of the plane
  TURGOR_CHECK(mass >= 0, "the effective mass of a push is not negative");
  const double least = dot(contact.force, contact.normal) / contact.reach;
  measure_stiffness(std::max(mass / (dt * dt), least), std::numeric_limits<double>::infinity(), memory,
                    contact);
  return contact;
}

}  // namespace turgor::contact

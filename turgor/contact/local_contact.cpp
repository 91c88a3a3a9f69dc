#include "turgor/contact/local_contact.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

constexpr double kMinBlendStep = 1e-6;  // smallest reduction of a jump in a tick, so that it ends [N]

/// Normal and tangential component of a force.
struct ForceComponents {
  double normal_force = 0;  // along the normal
  Vec3d tangential;         // across the normal
};
ForceComponents components_of(Vec3d force, Vec3d normal) {
  const double normal_force = dot(force, normal);
  return {normal_force, force - normal * normal_force};
}

/// Projects a force onto the friction cone: f_n ≥ 0, |f_t| ≤ μ f_n. A held contact is not limited.
Vec3d friction_cone(const LocalContact& c, Vec3d force) {
  if (c.is_held) return force;
  auto [normal_force, tangential] = components_of(force, c.normal);
  normal_force = std::max(normal_force, 0.0);
  const double limit = c.friction * normal_force, length = norm(tangential);
  return c.normal * normal_force + tangential * (length > limit ? limit / length : 1);
}

/// Depth of the tool below the position at which the plane's force is zero [m].
double effective_depth(const LocalContact& c, Vec3d position) {
  const double normal_force = dot(c.force, c.normal);
  const double pressed =
      c.stiffness > 0 ? (c.is_held ? normal_force : std::max(0.0, normal_force)) / c.stiffness : 0;
  return pressed - c.gap + std::min(dot(c.origin - position, c.normal), c.reach);
}

/// Force of a needle along the normal: a spring between two bounds, where it slips. A tip on the surface
/// punctures it at the upper bound, and the force drops in that tick.
double push_of_needle(LocalTouch& touch, double depth) {
  LocalContact& c = touch.contact;
  const double trial = c.stiffness * (depth + touch.slip);
  if (c.needle.is_touching && trial >= c.needle.highest)
    c.needle.is_touching = false, c.needle.highest = c.needle.after_puncture;
  const double push = std::clamp(trial, c.needle.lowest, c.needle.highest);
  if (push != trial && c.stiffness > 0) touch.slip = push / c.stiffness - depth;
  return push;
}

/// Spring force of the plane: f_n = k depth, f_t = k_s (proxy − x), projected onto the friction cone. Moves
/// the proxy where it slides.
Vec3d plane_force(LocalTouch& touch, Vec3d position) {
  const LocalContact& c = touch.contact;
  if (!c.is_near) return {};
  const double depth = effective_depth(c, position);
  const double normal_force = c.needle.is_needle ? push_of_needle(touch, depth) : c.stiffness * depth;
  const Vec3d offset = touch.proxy - position;
  const Vec3d tangent = offset - c.normal * dot(offset, c.normal);
  const Vec3d force = c.normal * normal_force + tangent * c.shear_stiffness;
  if (c.is_held) return force;
  const Vec3d limited = friction_cone(c, force);
  const Vec3d tangential = components_of(limited, c.normal).tangential;
  touch.proxy = c.shear_stiffness > 0 ? position + tangential / c.shear_stiffness : position;
  return limited;
}

/// Proxy position at which the plane's force equals the frame's force at the frame's pose.
Vec3d initial_proxy(const LocalContact& c) {
  const Vec3d force = c.is_held ? c.force : friction_cone(c, c.force);
  const Vec3d tangential = components_of(force, c.normal).tangential;
  return c.shear_stiffness > 0 ? c.origin + tangential / c.shear_stiffness : c.origin;
}

/// Adds the remaining force jump and reduces it.
Vec3d blended(LocalTouch& touch, Vec3d force, double dt) {
  // exponential decay, limited by the largest and the smallest step
  TURGOR_CHECK(touch.params.blend_time > 0, "a force jump decays in a positive time");
  const double length = norm(touch.remaining_jump),
               normal_force = std::max(0.0, dot(force, touch.contact.normal));
  double decay = std::exp(-dt / touch.params.blend_time);
  if (length * (1 - decay) > touch.params.largest_step) decay = 1 - touch.params.largest_step / length;
  if (length * (1 - decay) < kMinBlendStep) decay = length > kMinBlendStep ? 1 - kMinBlendStep / length : 0;
  touch.remaining_jump *= decay;
  // less of the jump while the force is below the reference
  const double fraction =
      !touch.contact.is_held && normal_force < touch.reference ? normal_force / touch.reference : 1;
  return friction_cone(touch.contact, force + touch.remaining_jump * fraction);
}

/// Damping of the coupling: f (1 + d v_in). It grows with the force, so that it starts from zero at contact
/// and never pulls [Hunt, Crossley 1975].
Vec3d damped(const LocalTouch& touch, Vec3d force, Vec3d velocity) {
  const double inwards = -dot(velocity, touch.contact.normal);
  return force * std::clamp(1 + touch.params.damping * inwards, 0.0, 2.0);
}

/// Vibration of a tool whose proxy slipped from `before` in a tick.
Vec3d vibration(LocalTouch& touch, Vec3d before, double dt) {
  const LocalContact& c = touch.contact;
  const Texture texture{c.waves, touch.map};
  if (!is_rough(texture) || c.needle.is_needle) return {};
  const double force = std::max(0.0, dot(touch.force, c.normal));
  const Vec3d slip = components_of(touch.proxy - before, c.normal).tangential;
  const Vec3d point = slid_point(touch.texture, touch.position, slip);
  return texture_force(texture, touch.texture,
                       {.point = point, .normal = c.normal, .force = force, .is_slip = !c.is_held}, dt);
}

}  // namespace

void end_contact(LocalTouch& touch) {
  TextureState texture = touch.texture;  // its statistics
  texture.is_touching = false;
  touch = {.params = touch.params, .map = std::move(touch.map), .contact = {}, .texture = texture};
}

void update_contact(LocalTouch& touch, const LocalContact& contact) {
  TURGOR_CHECK(is_unit(contact.normal), "the normal of a plane is a unit vector");
  TURGOR_CHECK(!(contact.stiffness < 0) && !(contact.shear_stiffness < 0),
               "the stiffness of a contact is not negative");  // NaN gives no force
  const Vec3d before = touch.force;
  touch.contact = contact;
  touch.proxy = initial_proxy(contact), touch.slip = 0;
  touch.remaining_jump = {}, touch.reference = 0;
  if (!touch.seen) return;
  // force jump by the new plane
  const Vec3d now = plane_force(touch, touch.position);
  touch.remaining_jump = before - now;
  touch.reference = std::max(0.0, dot(now, contact.normal));
  touch.largest_jump = std::max(touch.largest_jump, norm(touch.remaining_jump));
}

void tick_local_touch(LocalTouch& touch, const ToolCommand& command, double dt, ToolReading& reading) {
  TURGOR_CHECK(dt >= 0, "ticks do not run backwards");
  reading = {};
  // invalid pose: no force
  if (!is_valid(command.pose)) {
    touch.seen = false, touch.remaining_jump = touch.force = {};
    return;
  }
  // spring force, blended
  const Vec3d position = command.pose.position, proxy = touch.proxy;
  touch.force = blended(touch, plane_force(touch, position), dt);
  // damping by the tool's velocity
  const Vec3d velocity = touch.seen && dt > 0 ? (position - touch.position) / dt : Vec3d{};
  touch.seen = true, touch.position = position;
  reading.force = damped(touch, touch.force, velocity) + vibration(touch, proxy, dt);
  // reading
  reading.torque = cross(touch.contact.arm, reading.force);
  reading.contacts = touch.force != Vec3d{} ? 1 : 0;
  if (reading.contacts > 0) reading.depth = std::max(0.0, effective_depth(touch.contact, position));
  reading.beyond_patch = touch.contact.is_near && norm(position - touch.contact.origin) > touch.contact.reach;
}

}  // namespace turgor::contact

#include "turgor/contact/local_contact.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::contact {

namespace {

constexpr double kLeastStep = 1e-6;  // by which what is left of a jump shrinks in a tick, so that it ends [N]

/// A force by the plane's normal.
struct Parts {
  double pressing = 0;  // along the normal
  Vec3d rubbing;        // across it
};
Parts parts_of(Vec3d force, Vec3d normal) {
  const double pressing = dot(force, normal);
  return {pressing, force - normal * pressing};
}

/// Never pulling, and within friction's cone, unless it is held.
Vec3d allowed(const LocalContact& c, Vec3d force) {
  if (c.is_held) return force;
  auto [pressing, rubbing] = parts_of(force, c.normal);
  pressing = std::max(pressing, 0.0);
  const double most = c.friction * pressing, length = norm(rubbing);
  return c.normal * pressing + rubbing * (length > most ? most / length : 1);
}

/// How far the tool is below where it would feel nothing [m].
double depth_of(const LocalContact& c, Vec3d position) {
  const double pressing = dot(c.force, c.normal);
  const double pressed = c.stiffness > 0 ? (c.is_held ? pressing : std::max(0.0, pressing)) / c.stiffness : 0;
  return pressed - c.gap + std::min(dot(c.origin - position, c.normal), c.reach);
}

/// Of the plane's springs alone; moves the proxy where it slides.
Vec3d plane_force(LocalTouch& touch, Vec3d position) {
  const LocalContact& c = touch.contact;
  if (!c.is_near) return {};
  const double pressing = c.stiffness * depth_of(c, position);
  const Vec3d off = touch.proxy - position;
  const Vec3d along = off - c.normal * dot(off, c.normal);
  const Vec3d force = c.normal * pressing + along * c.shear_stiffness;
  if (c.is_held) return force;
  const Vec3d borne = allowed(c, force);
  const Vec3d rubbing = parts_of(borne, c.normal).rubbing;
  touch.proxy = c.shear_stiffness > 0 ? position + rubbing / c.shear_stiffness : position;
  return borne;
}

/// Where the proxy is when the tool is where the frame had it, and feels what it felt there.
Vec3d proxy_of(const LocalContact& c) {
  const Vec3d force = c.is_held ? c.force : allowed(c, c.force);
  const Vec3d rubbing = parts_of(force, c.normal).rubbing;
  return c.shear_stiffness > 0 ? c.origin + rubbing / c.shear_stiffness : c.origin;
}

/// Adds what is left of the last jump, and lets it shrink.
Vec3d blended(LocalTouch& touch, Vec3d force, double dt) {
  const double length = norm(touch.rest), pressing = std::max(0.0, dot(force, touch.contact.normal));
  double kept = std::exp(-dt / touch.params.blend_time);
  if (length * (1 - kept) > touch.params.largest_step) kept = 1 - touch.params.largest_step / length;
  if (length * (1 - kept) < kLeastStep) kept = length > kLeastStep ? 1 - kLeastStep / length : 0;
  touch.rest *= kept;
  const double share = !touch.contact.is_held && pressing < touch.reference ? pressing / touch.reference : 1;
  return allowed(touch.contact, force + touch.rest * share);
}

/// Dampers of the coupling, by which it loses energy: stronger the deeper, so that they begin with the touch
/// and never pull [Hunt, Crossley 1975].
Vec3d damped(const LocalTouch& touch, Vec3d force, Vec3d velocity) {
  const double inwards = -dot(velocity, touch.contact.normal);
  return force * std::clamp(1 + touch.params.damping * inwards, 0.0, 2.0);
}

}  // namespace

void take(LocalTouch& touch, const LocalContact& contact) {
  const Vec3d before = touch.force;
  touch.contact = contact;
  touch.proxy = proxy_of(contact);
  touch.rest = {}, touch.reference = 0;
  if (!touch.seen) return;
  const Vec3d now = plane_force(touch, touch.position);
  touch.rest = before - now;
  touch.reference = std::max(0.0, dot(now, contact.normal));
  touch.largest_jump = std::max(touch.largest_jump, norm(touch.rest));
}

void tick(LocalTouch& touch, const ToolCommand& command, double dt, ToolReading& reading) {
  reading = {};
  if (!is_valid(command.pose)) {
    touch.seen = false, touch.rest = touch.force = {};
    return;
  }
  const Vec3d position = command.pose.position;
  touch.force = blended(touch, plane_force(touch, position), dt);
  const Vec3d velocity = touch.seen && dt > 0 ? (position - touch.position) / dt : Vec3d{};
  touch.seen = true, touch.position = position;
  reading.force = damped(touch, touch.force, velocity);
  reading.torque = cross(touch.contact.arm, reading.force);
  reading.contacts = touch.force != Vec3d{} ? 1 : 0;
  if (reading.contacts > 0) reading.depth = std::max(0.0, depth_of(touch.contact, position));
  reading.beyond_patch = touch.contact.is_near && norm(position - touch.contact.origin) > touch.contact.reach;
}

}  // namespace turgor::contact

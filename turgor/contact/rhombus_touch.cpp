#include "turgor/contact/rhombus_touch.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Lowest end of any shape in its frame.
RhombusTip lowest_end(const Shape& shape) {
  Vec3d lowest = tip(shape, 0);
  for (int n = 1; n < tip_count(shape); n++)
    if (const Vec3d other = tip(shape, n); other.z < lowest.z) lowest = other;
  const double radius = tip_radius(shape);
  return {.center = lowest + Vec3d{0, 0, radius}, .radius = radius};
}

/// Contact of a tool with the rough surface. Chains have no friction, so that a tool slides unless it holds.
TextureContact texture_contact(const rhombus::ToolTouch& tool, const rhombus::TouchForce& haptic) {
  return {.point = tool.foot.at.position,
          .normal = tool.foot.normal,
          .force = haptic.touching ? std::max(0.0, dot(haptic.force, tool.foot.normal)) : 0,
          .is_slip = !tool.holding};
}

ToolReading reading_of(const rhombus::TouchForce& haptic, Vec3d vibration, Vec3d arm) {
  const Vec3d force = haptic.force + vibration;
  return {.force = force,
          .torque = cross(arm, force),
          .squeeze = haptic.squeeze,
          .depth = haptic.touching ? haptic.depth : 0,
          .contacts = haptic.touching ? 1 : 0};
}

}  // namespace

RhombusTip rhombus_tip(const Shape& shape, const std::optional<Forceps>& forceps) {
  if (forceps)
    return {
        .center = {0, 0, forceps->tip_radius}, .radius = forceps->tip_radius, .opening = forceps->opening};
  if (const auto* ball = std::get_if<Sphere>(&shape)) return {.center = {}, .radius = ball->radius};
  if (const auto* rod = std::get_if<Capsule>(&shape))
    return {.center = {0, 0, -rod->half_length}, .radius = rod->radius};
  return lowest_end(shape);
}

rhombus::TouchInput touch_input(const RhombusTip& tip, const Pose& pose, double grip) {
  TURGOR_CHECK(grip >= 0 && grip <= 1, "a grip is from 0, open, to 1, closed");
  return {.position = to_world(pose, tip.center),
          .axes = pose.axes,
          .radius = tip.radius,
          .grip = grip,
          .opening = tip.opening * (1 - grip)};
}

RhombusTouch make_rhombus_touch(std::vector<RhombusTip> tips, std::span<const Pose> poses,
                                const Prony& viscosity, const Texture& texture) {
  const std::size_t count = tips.size();
  TURGOR_ASSERT(count <= std::size_t(rhombus::kMaxTouches), "at most kMaxTouches tools touch one body");
  TURGOR_ASSERT(poses.size() == count, "one pose a tool");
  return {.tips = std::move(tips),
          .touches = std::vector<rhombus::ToolTouch>(count),
          .poses = {poses.begin(), poses.end()},
          .inputs = std::vector<rhombus::TouchInput>(count),
          .forces = std::vector<rhombus::TouchForce>(count),
          .tissue = {.viscosity = viscosity, .waves = texture.waves},
          .map = texture.map,
          .textures = std::vector<TextureState>(count)};
}

void tick_rhombus_touch(const rhombus::Model& model, RhombusTouch& touch,
                        std::span<const ToolCommand> commands, double dt, std::span<ToolReading> readings) {
  TURGOR_ASSERT(commands.size() == touch.tips.size() && readings.size() == touch.tips.size(),
                "one command and one reading a tool");
  for (std::size_t t = 0; t < commands.size(); t++) {
    touch.poses[t] = commands[t].pose;
    touch.touches[t].stiffness_scale = touch.tissue.stiffness_scale;
    touch.inputs[t] = touch_input(touch.tips[t], commands[t].pose, commands[t].grip);
  }
  rhombus::solve_touches(model, touch.tissue.viscosity, touch.touches, touch.inputs, dt, touch.forces);
  const Texture texture{touch.tissue.waves, touch.map};
  for (std::size_t t = 0; t < commands.size(); t++) {
    const Vec3d vibration =
        texture_force(texture, touch.textures[t], texture_contact(touch.touches[t], touch.forces[t]), dt);
    readings[t] =
        reading_of(touch.forces[t], vibration, touch.inputs[t].position - commands[t].pose.position);
  }
  touch.ticks++;
}

void publish(const RhombusTouch& touch, RhombusTouchSnapshot& now) {
  now.touches = touch.touches;
  now.poses = touch.poses;
  now.inputs = touch.inputs;
  now.forces = touch.forces;
  now.ticks = touch.ticks;
  now.textures = touch.textures;
}

void tick_and_publish(const rhombus::Model& model, RhombusTouch& touch, latest<RhombusTissue>& tissue,
                      latest<RhombusTouchSnapshot>& touched, std::span<const ToolCommand> commands, double dt,
                      std::span<ToolReading> readings) {
  if (tissue.has_news()) touch.tissue = tissue.read();
  tick_rhombus_touch(model, touch, commands, dt, readings);
  publish(touch, touched.writing());
  touched.publish();
}

void prepare(const RhombusTouch& touch, latest<RhombusTouchSnapshot>& touched) {
  for (int slot = 0; slot < 3; slot++) {  // each slot of latest<> passes the writer once
    publish(touch, touched.writing());
    touched.publish();
    touched.read();
  }
}

}  // namespace turgor::contact

#include "turgor/contact/sfem_touch.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

double part_of(const FreeWay& way) { return double(way.done) / double(way.ticks); }

Vec3d free_motion(const FreeWay& way, std::size_t vertex, double part) {
  return way.from[vertex] * (1 - part) + way.to[vertex] * part;
}

/// Where the points of the patch would lie without tools.
void set_offsets(SfemTouch& touch) {
  FreeWay& way = touch.free;
  if (!way.moves) return;
  way.done = std::min(way.done + 1, way.ticks);
  const double part = part_of(way);
  for (std::size_t p = 0; p < touch.patch->points.size(); p++) {
    const sfem::PatchPoint& point = touch.patch->points[p];
    Vec3d offset;
    for (std::size_t s = 0; s < std::size_t(point.supports); s++) {
      const auto v = std::size_t(touch.patch->coarse[std::size_t(point.coarse[s])]);
      offset += free_motion(way, v, part) * point.weight[s];
    }
    touch.state.offset[p] = offset;
  }
}

ToolReading reading_of(const SfemTouch& touch, std::size_t tool) {
  const ToolForce& haptic = touch.forces[tool];
  ToolReading reading{.force = haptic.force * touch.stiffer,
                      .torque = haptic.torque * touch.stiffer,
                      .contacts = haptic.contacts,
                      .beyond_patch = haptic.beyond_patch};
  if (haptic.contacts > 0)
    reading.depth =
        depth_at_rest(*touch.patch, touch.state.surface, touch.tools[tool].shape, touch.poses[tool].pose);
  return reading;
}

}  // namespace

SfemTouch make_sfem_touch(std::shared_ptr<const sfem::Patch> patch, std::vector<Tool> tools,
                          std::span<const Pose> poses, const SfemTouchParams& params) {
  TURGOR_ASSERT(poses.size() == tools.size(), "one pose a tool");
  SfemTouch touch{.patch = std::move(patch), .tools = std::move(tools), .follow = params.follow};
  const std::size_t spare = 2 * touch.patch->points.size() + 64;  // later patches are about as large
  touch.state = make_touch_state(*touch.patch, touch.tools.size(), params.touch, spare);
  if (params.touch.viscosity.stiffening > 0) touch.state.history.far.reserve(params.vertex_count);
  touch.free.from.resize(params.vertex_count);
  touch.free.to.resize(params.vertex_count);
  for (const Pose& pose : poses) touch.poses.push_back({pose, false});
  touch.forces.resize(touch.tools.size());
  return touch;
}

void tick(SfemTouch& touch, std::span<const ToolCommand> commands, double dt,
          std::span<ToolReading> readings) {
  TURGOR_ASSERT(commands.size() == touch.tools.size() && readings.size() == touch.tools.size(),
                "one command and one reading a tool");
  for (std::size_t t = 0; t < commands.size(); t++) touch.poses[t] = {commands[t].pose, commands[t].hold};
  set_offsets(touch);
  contact::touch(*touch.patch, touch.state, touch.tools, touch.poses, dt, touch.forces);
  blend(touch.follow, touch.state, dt, touch.forces);
  for (std::size_t t = 0; t < commands.size(); t++) readings[t] = reading_of(touch, t);
  touch.ticks++;
}

void take_frame(SfemTouch& touch, std::span<const Vec3d> to, long ticks) {
  if (to.empty()) return;
  FreeWay& way = touch.free;
  TURGOR_ASSERT(to.size() == way.to.size(), "one free motion a vertex");
  if (way.done >= way.ticks || !way.moves)
    std::swap(way.from, way.to);
  else
    for (std::size_t v = 0; v < to.size(); v++) way.from[v] = free_motion(way, v, part_of(way));
  std::copy(to.begin(), to.end(), way.to.begin());
  way.moves = true;
  way.ticks = std::max(1l, ticks), way.done = 0;
}

Handover take_patch(SfemTouch& touch, const PatchOffer& offer) {
  touch.handover = take_patch(touch.state, *touch.patch, *offer.patch, touch.tools, offer.history);
  touch.patch = offer.patch;
  touch.taken = offer.number;
  return touch.handover;
}

void publish(const SfemTouch& touch, TouchedNow& now) {
  now.patch = touch.patch;
  now.taken = touch.taken;
  now.ticks = touch.ticks;
  now.force_jump = touch.handover.force_jump;
  now.x = touch.state.x;
  now.force = touch.state.force;
  now.history = touch.state.history;
  now.stiffening = touch.state.params.viscosity.stiffening;
  now.stiffer = touch.stiffer;
  now.poses = touch.poses;
  now.forces = touch.forces;
  for (ToolForce& haptic : now.forces) haptic.force *= touch.stiffer, haptic.torque *= touch.stiffer;
  now.middles.resize(touch.tools.size());
  find_middles(*touch.patch, touch.state, now.middles);
}

void reserve_like(const SfemTouch& touch, TouchedNow& now) {
  for (auto* points : {&now.x, &now.force}) points->reserve(touch.state.x.capacity());
  if (!touch.state.history.v.empty())
    for (auto* points : {&now.history.v, &now.history.phi}) points->reserve(touch.state.x.capacity());
  now.history.far.reserve(touch.state.history.far.capacity());
  publish(touch, now);
}

void prepare(const SfemTouch& touch, SfemExchange& exchange) {
  for (int slot = 0; slot < 3; slot++) {  // each of latest's comes to the writer once
    reserve_like(touch, exchange.touched.writing());
    exchange.touched.publish();
    exchange.touched.read();
  }
}

void tick(SfemTouch& touch, SfemExchange& exchange, std::span<const ToolCommand> commands, double dt,
          std::span<ToolReading> readings) {
  if (exchange.motion.has_news()) {
    const FreeMotion& motion = exchange.motion.read();
    take_frame(touch, motion.to, motion.ticks);
    touch.frame = motion.number, touch.stiffer = motion.stiffer;
    for (std::size_t t = 0; t < motion.friction.size(); t++) touch.tools[t].friction = motion.friction[t];
  }
  if (exchange.patches.has_news()) take_patch(touch, exchange.patches.read());
  tick(touch, commands, dt, readings);
  publish(touch, exchange.touched.writing());
  exchange.touched.publish();
}

}  // namespace turgor::contact

#include "app/haptic_loops.hpp"

#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>

#include "app/empty_loop.hpp"
#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/haptics/loop.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor {

namespace {

constexpr double kTip = 0.005;  // radius of the tool [m]

void tick_nothing(void* /*context*/, std::span<const contact::ToolCommand>, double,
                  std::span<contact::ToolReading>) {}

/// A wall at z = 0 of 500 N/m.
void tick_wall(void* /*context*/, std::span<const contact::ToolCommand> commands, double,
               std::span<contact::ToolReading> readings) {
  for (std::size_t i = 0; i < commands.size(); i++)
    readings[i].force.z = 500 * std::max(0.0, -commands[i].pose.position.z);
}

/// A liver of rhombus chains with the state of its haptic loop.
struct Chain {
  rhombus::Model model;
  rhombus::FootPoint foot;  // center of the taps on the surface
  contact::RhombusTouch touch;
  latest<contact::RhombusTissue> tissue;
  latest<contact::RhombusTouchSnapshot> touched;
};

void tick_chain(void* context, std::span<const contact::ToolCommand> commands, double dt,
                std::span<contact::ToolReading> readings) {
  Chain& chain = *static_cast<Chain*>(context);
  contact::tick_and_publish(chain.model, chain.touch, chain.tissue, chain.touched, commands, dt, readings);
}

void make_chain(Chain& chain) {
  const TriMesh mesh = phantom_liver(1);
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  chain.model = std::move(*rhombus::build(std::move(body), {}));
  chain.foot = rhombus::find_foot_point(chain.model.surface, chain.model.tree, {-0.05, 0.01, 0.2});
  const contact::Pose above{.position = chain.foot.at.position + chain.foot.normal * 0.02, .axes = {}};
  chain.touch = contact::make_rhombus_touch({{.center = {}, .radius = kTip}}, std::span(&above, 1), {});
  contact::prepare(chain.touch, chain.touched);
}

/// Hand that moves up and down through z = 0, once a second.
haptics::HandTarget tapping(double time) {
  return {.pose = {.position = {0, 0, 0.005 * std::cos(2 * std::numbers::pi * time)}, .axes = {}}};
}

}  // namespace

const char* name_of(LoopModel model) {
  switch (model) {
    case LoopModel::kNone:
      return "none";
    case LoopModel::kWall:
      return "wall";
    case LoopModel::kRhombus:
      return "rhombus";
  }
  return "";
}

HapticLoopRow measure_loop(double rate, LoopModel model, double seconds) {
  haptics::VirtualDevice device({.rate = rate}, haptics::light_grip(tapping), haptics::VirtualTime::kClock);
  (void)device.open();
  Chain chain;
  haptics::Hand hand{.device = &device};
  if (model == LoopModel::kRhombus) {
    make_chain(chain);
    hand.workspace.origin = chain.foot.at.position + chain.foot.normal * kTip;
  }
  const haptics::ToolTick tick = model == LoopModel::kRhombus ? tick_chain
                                 : model == LoopModel::kWall  ? tick_wall
                                                              : tick_nothing;
  const haptics::LoopParams params{.rate = rate};
  auto loop = haptics::Loop::start({hand}, tick, &chain, params);
  EmptyLoop empty(rate, params.priority);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  (*loop)->stop();
  return {model, (*loop)->report(), empty.end(), (*loop)->notes()};
}

}  // namespace turgor

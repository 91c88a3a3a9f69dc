// A hand with a haptic device on one tool of a world, on one thread and without a clock. It runs a simulated
// arm, the safety chain, the model's ticks and its frames in the order of a live session.
#pragma once

#include <cmath>
#include <functional>

#include "tests/sim/four_kinds.hpp"
#include "turgor/haptics/safety.hpp"
#include "turgor/haptics/virtual_device.hpp"
#include "turgor/sim/live/live_touch.hpp"

namespace turgor::test {

class HapticHand {
 public:
  /// Follows the tool's own path with a light grip; the tool is the first of its body.
  HapticHand(World& world, int tool)
      : world_(world),
        id_(world.tools[std::size_t(tool)].body),
        start_(command_at(world.tools[std::size_t(tool)], 0)),
        device_({.workspace_low = {-1, -1, -1}, .workspace_high = {1, 1, 1}},
                haptics::light_grip([target_path = world.tools[std::size_t(tool)], this](double time) {
                  return haptics::HandTarget{
                      .pose = {command_at(target_path, time).pose.position - start_.pose.position, {}}};
                })) {
    EXPECT_TRUE(device_.open());
    safety_ = haptics::make_safety(device_.spec(), {.ramp = 0.01});
    for_each_touched(world_, [&](BodyId id, auto& body) {
      if (id == id_) begin_haptics(body, world_.tools);
    });
  }
  ~HapticHand() {
    for_each_touched(world_, [](BodyId, auto& body) { end_haptics(body); });
  }

  /// Runs ticks and the frames that become due; `frame` is called after each frame.
  void advance(double seconds, const std::function<void()>& frame = {}) {
    const double end = time_ + seconds;
    while (time_ < end - 1e-9) {
      tick();
      if (time_ + 1e-9 < next_frame_) continue;
      if (has_frames) {
        EXPECT_TRUE(step(Exec(2), world_));
      }
      if (frame) frame();
      next_frame_ += world_.dt;
    }
  }
  /// Stalls the loop for some time, while the hand continues to move.
  void stall(double seconds) {
    for (int n = 0; n < int(seconds / kTick); n++) device_.exchange(output_.value(), safety_input_.hand);
    time_ += seconds;
    apply_safety(seconds);
  }

  bool has_frames = true;  // false: the physics is stopped
  const haptics::Safety& safety() const { return safety_; }
  Vec3d force() const { return output_.value().force; }
  Vec3d requested_force() const { return safety_input_.wanted.force; }
  double speed() const { return norm(device_.velocity()); }
  double largest = 0,
         steepest = 0;  // largest force and largest change per tick, relative to their limits [1]
  bool finite = true;
  contact::ToolReading reading;

 private:
  void tick() {
    time_ += kTick;
    device_.exchange(output_.value(), safety_input_.hand);
    contact::ToolCommand command = start_;
    command.pose.position += safety_input_.hand.pose.position;
    reading = {};
    visit_body(world_, id_, [&](auto& body) {
      if constexpr (is_touched<decltype(body)>)
        tick_haptics(body, std::span(&command, 1), kTick, std::span(&reading, 1));
    });
    safety_input_.wanted.force = reading.force, safety_input_.age = reading.age;
    apply_safety(kTick);
  }
  void apply_safety(double dt) {
    const haptics::SafetyParams& p = safety_.params;
    const Vec3d before = force();
    output_ = haptics::make_safe(safety_, safety_input_, dt);
    const Vec3d after = force();
    finite = finite && std::isfinite(norm(after));
    largest = std::max(largest, norm(after) / p.force);
    steepest = std::max(steepest, norm(after - before) / (p.force * std::min(dt, 2 * kTick) / p.rise));
  }

  World& world_;
  BodyId id_;
  contact::ToolCommand start_;
  haptics::VirtualDevice device_;
  haptics::Safety safety_;
  haptics::SafeOutput output_;
  haptics::SafetyInput safety_input_;
  double time_ = 0, next_frame_ = 0;
};

/// The model may be wrong, but the device never receives a force above its limit or its slope.
inline void expect_harmless(const HapticHand& hand, const std::string& what) {
  EXPECT_TRUE(hand.finite) << what;
  EXPECT_LE(hand.largest, 1 + 1e-12) << what;
  EXPECT_LE(hand.steepest, 1 + 1e-9) << what;
}

}  // namespace turgor::test

#include "turgor/haptics/safety.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {
namespace {

constexpr double kTick = 1e-3, kNan = std::numeric_limits<double>::quiet_NaN(),
                 kInf = std::numeric_limits<double>::infinity();
const DeviceSpec kArm{.name = "arm", .force = 12, .torque = 0.4, .grip_force = 8, .damping = 30, .mass = 0.2};

/// A safety stage whose soft start is complete.
Safety started(SafetyParams params = {}) {
  params.ramp = kTick;
  Safety safety = make_safety(kArm, params);
  for (int i = 0; i < 10; i++) make_safe(safety, {}, kTick);
  EXPECT_EQ(safety.start, SoftStart::kFull);
  safety.counts = {};
  return safety;
}

SafetyInput input_with(Vec3d force, double age = 0) {
  SafetyInput input;
  input.wanted.force = force;
  input.age = age;
  return input;
}

/// Output after the same input for several ticks.
DeviceOutput after(Safety& safety, const SafetyInput& input, int ticks) {
  SafeOutput out;
  for (int i = 0; i < ticks; i++) out = make_safe(safety, input, kTick);
  return out.value();
}

// A small force that changes slowly passes unchanged.
TEST(Safety, SmallSlowForcePassesUnchanged) {
  Safety safety = started();
  for (int i = 0; i < 1000; i++) {
    const Vec3d force{2 * std::sin(0.01 * i), 0, 1 - std::cos(0.02 * i)};
    EXPECT_LT(norm(make_safe(safety, input_with(force), kTick).value().force - force), 1e-12);
  }
  const SafetyCounts& c = safety.counts;
  EXPECT_EQ(c.not_finite + c.silent + c.waiting + c.ramping + c.damped + c.slewed + c.saturated + c.lost, 0u);
  EXPECT_EQ(c.ticks, 1000u);
}

// A force or torque that is not finite becomes zero.
TEST(Safety, NonFiniteOutputBecomesZero) {
  for (const double wrong : {kNan, kInf, -kInf}) {
    Safety safety = started();
    EXPECT_EQ(norm(after(safety, input_with({1, wrong, 0}), 3).force), 0);
    SafetyInput input;
    input.wanted.torque.z = wrong;
    EXPECT_EQ(norm(after(safety, input, 3).torque), 0);
    EXPECT_EQ(safety.counts.not_finite, 6u);
  }
}

// A loop that starts inside a body gives no force until the tool has left it.
TEST(Safety, StartInContactGivesNoForce) {
  Safety safety = make_safety(kArm, {});
  EXPECT_EQ(norm(after(safety, input_with({0, 0, 3}), 5000).force), 0);
  EXPECT_EQ(safety.counts.waiting, 5000u);
  after(safety, input_with({}), safety.params.calm_ticks);
  EXPECT_EQ(safety.start, SoftStart::kRamping);
}

// After the start the force rises linearly over the ramp.
TEST(Safety, RampIsLinear) {
  Safety safety = make_safety(kArm, {});
  after(safety, input_with({}), 3);
  EXPECT_NEAR(after(safety, input_with({0, 0, 3}), 250).force.z, 0.75, 1e-9);
  EXPECT_NEAR(after(safety, input_with({0, 0, 3}), 500).force.z, 2.25, 1e-9);
  EXPECT_NEAR(after(safety, input_with({0, 0, 3}), 251).force.z, 3, 1e-9);
  EXPECT_EQ(safety.start, SoftStart::kFull);
}

// The ramp starts only after enough calm ticks.
TEST(Safety, RampNeedsCalmPeriod) {
  Safety safety = make_safety(kArm, {});
  for (int i = 0; i < 100; i++) make_safe(safety, input_with({0, 0, i % 3 ? 0 : 1.0}), kTick);
  EXPECT_EQ(safety.start, SoftStart::kWaiting);
}

// A jump of the hand restarts the soft start; fast motion does not.
TEST(Safety, JumpRestartsSoftStart) {
  Safety safety = started();
  SafetyInput input = input_with({0, 0, 2});
  for (int i = 0; i < 100; i++) {  // at 2 m/s, a fast hand
    input.hand.pose.position.x += 0.002;
    make_safe(safety, input, kTick);
  }
  EXPECT_EQ(safety.counts.jumped, 0u);
  EXPECT_EQ(safety.start, SoftStart::kFull);
  input.hand.pose.position.x += 0.05;
  EXPECT_EQ(norm(after(safety, input, 50).force),
            0);  // inside a body after the jump: zero until the tool has left it
  EXPECT_EQ(safety.counts.jumped, 1u);
  EXPECT_EQ(safety.start, SoftStart::kWaiting);
}

// Invalid limits allow no force, and the shortest rise time is one millisecond.
TEST(Safety, InvalidLimitsGiveNoForce) {
  for (const double wrong : {kNan, -1.0, 0.0}) {
    Safety safety = started({.force = wrong, .torque = wrong, .rise = wrong});
    EXPECT_EQ(norm(after(safety, input_with({0, 0, 5}), 100).force), 0) << wrong;
  }
  for (const double steep : {kNan, -1.0, 0.0, 1e-9}) {
    Safety safety = started({.rise = steep});
    EXPECT_NEAR(make_safe(safety, input_with({0, 0, 10}), 0.5e-3).value().force.z, 5, 1e-9) << steep;
  }
  EXPECT_EQ(make_safety({.force = kNan}, {}).params.force, 0);
}

// Generated energy is dissipated by damping.
TEST(Safety, GeneratedEnergyIsDamped) {
  Safety safety = started();
  SafetyInput input = input_with({0, 0, 1});
  input.hand.velocity = {0, 0, 0.1};
  for (int i = 0; i < 100; i++) {  // pushed along the motion: 1 N · 0.1 m/s
    input.hand.pose.position.z = 1e-4 * i;
    make_safe(safety, input, kTick);
  }
  EXPECT_LT(safety.passivity.lowest, -1e-4);
  EXPECT_GT(safety.counts.damped, 90u);
  EXPECT_NEAR(safety.passivity.held_output.force.z, 1 - 0.1 * safety.params.passivity.damping, 0.05);
}

// A jump of the force is limited to the slew rate.
TEST(Safety, ForceJumpIsSlewed) {
  Safety safety = started();
  for (int i = 1; i <= 5; i++)
    EXPECT_NEAR(make_safe(safety, input_with({6, 8, 0}), kTick).value().force.y, 0.8 * 2 * i, 1e-9);
  EXPECT_EQ(safety.counts.slewed, 4u);  // the fifth step reaches the target
}

// A late tick may change the force by at most two periods of the slew rate.
TEST(Safety, LateTickSlewsTwoPeriodsAtMost) {
  Safety safety = started();
  EXPECT_NEAR(make_safe(safety, input_with({10, 0, 0}), 0.5).value().force.x, 4, 1e-9);
}

// Saturation limits the norm of the force and keeps its direction.
TEST(Safety, SaturationKeepsDirection) {
  Safety safety = started();
  const DeviceOutput haptic = after(safety, input_with({30, -40, 0}), 50);
  EXPECT_NEAR(haptic.force.x, 6, 1e-9);
  EXPECT_NEAR(haptic.force.y, -8, 1e-9);
  EXPECT_EQ(safety.counts.saturated, 45u);  // all except the five steps of the ramp
}

// The smaller limit of user and device applies.
TEST(Safety, SmallerLimitApplies) {
  for (const double user : {3.0, 500.0}) {
    Safety safety = started({.force = user, .torque = user});
    EXPECT_NEAR(norm(after(safety, input_with({0, 0, 1e9}), 100).force), std::min(user, 12.0), 1e-9);
    EXPECT_NEAR(safety.params.torque, std::min(user, 0.4), 1e-12);
  }
  Safety three_axes = make_safety({.force = 5}, {});
  EXPECT_EQ(three_axes.params.torque, 0);
}

// The force of a silent model fades to damping and then to zero.
TEST(Safety, SilentModelFadesToDamping) {
  Safety safety = started();
  after(safety, input_with({0, 0, 2}, 0.09), 100);
  EXPECT_NEAR(safety.passivity.held_output.force.z, 2, 1e-9);
  SafetyInput silent = input_with({0, 0, 2}, 0.11);
  silent.hand.velocity = {0, 0.1, 0};
  EXPECT_NEAR(after(safety, silent, 50).force.y, -0.1 * safety.params.silent_damping, 1e-9);
  EXPECT_NEAR(safety.passivity.held_output.force.z, 0, 1e-9);
  EXPECT_NEAR(after(safety, silent, 700).force.y, -0.05 * safety.params.silent_damping, 2e-3);
  EXPECT_EQ(norm(after(safety, silent, 300).force), 0);
  EXPECT_EQ(safety.counts.silent, 1050u);
  after(safety, input_with({0, 0, 2}), 100);  // the model answers again: soft start
  EXPECT_EQ(safety.start, SoftStart::kWaiting);
  after(safety, input_with({0, 0, 2}, kNan), 1);
  EXPECT_EQ(safety.counts.silent, 1051u);
}

// A device that does not answer gets zero force.
TEST(Safety, LostDeviceGetsNoForce) {
  Safety safety = started();
  after(safety, input_with({0, 0, 2}), 100);
  SafetyInput unanswered = input_with({0, 0, 2});
  unanswered.answered = false;
  after(safety, unanswered, 49);
  EXPECT_FALSE(safety.is_lost);
  EXPECT_EQ(norm(after(safety, unanswered, 5).force), 0);
  EXPECT_TRUE(safety.is_lost);
  EXPECT_EQ(norm(after(safety, unanswered, 1000).force), 0);
  EXPECT_TRUE(safety.is_lost);
  EXPECT_GT(safety.counts.lost, 1000u);
  // answers with gaps are none
  for (int i = 0; i < 1000; i++) make_safe(safety, i % 20 ? input_with({}) : unanswered, kTick);
  EXPECT_TRUE(safety.is_lost);
}

/// A safety stage whose device was lost while it rendered 2 N.
Safety lost(SafetyParams params = {}) {
  Safety safety = started(params);
  after(safety, input_with({0, 0, 2}), 100);
  SafetyInput unanswered = input_with({0, 0, 2});
  unanswered.answered = false;
  after(safety, unanswered, 200);
  EXPECT_TRUE(safety.is_lost);
  return safety;
}

// A lost device returns after 50 ms of answers. If its hand is deep inside a body by then, there is no force
// until it has left the body, whether its motion counts as a jump or not. Then the force rises over the ramp.
TEST(Safety, ReturnedDeviceStartsSoftly) {
  for (const double moved : {0.0, 0.02, 0.2}) {  // [m]
    Safety safety = lost();
    safety.params.ramp = 1;
    SafetyInput inside = input_with({0, 0, 9});
    inside.hand.pose.position.z = -moved;
    EXPECT_EQ(norm(after(safety, inside, 45).force), 0);
    EXPECT_TRUE(safety.is_lost);
    EXPECT_EQ(norm(after(safety, inside, 10).force), 0);
    EXPECT_FALSE(safety.is_lost);
    EXPECT_EQ(norm(after(safety, inside, 5000).force), 0);
    SafetyInput outside = inside;
    outside.wanted = {};
    EXPECT_EQ(norm(after(safety, outside, safety.params.calm_ticks).force), 0);
    double before = 0;
    for (int n = 1; n <= 1000; n++) {
      const double force = after(safety, inside, 1).force.z;
      EXPECT_NEAR(force, 9 * 1e-3 * n, 1e-9);
      EXPECT_LE(force - before, 10 * kTick / 0.005);
      before = force;
    }
    EXPECT_EQ(safety.start, SoftStart::kFull);
  }
}

// The ramp lasts as long in a slow loop, and a tick changes the force by the same fraction of the limit.
TEST(Safety, SlowLoopKeepsTimesAndSteps) {
  constexpr double kSlow = 0.01;
  Safety safety = make_safety(kArm, {}, kSlow);
  const auto ticks = [&](double force, int count) {
    SafeOutput out;
    for (int n = 0; n < count; n++) out = make_safe(safety, input_with({0, 0, force}), kSlow);
    return out.value().force.z;
  };
  ticks(0, safety.params.calm_ticks);
  EXPECT_NEAR(ticks(3, 50), 1.5, 1e-9);
  EXPECT_NEAR(ticks(3, 49), 2.97, 1e-9);
  EXPECT_NE(safety.start, SoftStart::kFull);
  EXPECT_NEAR(ticks(3, 1), 3, 1e-9);
  EXPECT_EQ(safety.start, SoftStart::kFull);
  ticks(0, 50);
  EXPECT_NEAR(ticks(9, 1), 2, 1e-9) << "a fifth of the limit, as at 1 kHz";
  EXPECT_NEAR(make_safe(safety, input_with({0, 0, 9}), 10).value().force.z, 6, 1e-9) << "two periods at most";
}

// The damping that a device renders follows from the period of the loop, not from its design rate.
TEST(Safety, DampingFollowsPeriodOfLoop) {
  const DeviceSpec fast{.force = 12, .mass = 0.01, .rate = 4000};
  EXPECT_NEAR(make_safety(fast, {}, 1e-3).params.passivity.damping, 5, 1e-12);  // m / 2T
  EXPECT_NEAR(make_safety(fast, {}).params.passivity.damping, 10, 1e-12);       // the user's
}

// Single missed answers do not count as a lost device.
TEST(Safety, SingleMissedAnswerIsTolerated) {
  Safety safety = started();
  SafetyInput unanswered = input_with({0, 0, 2});
  unanswered.answered = false;
  for (int i = 0; i < 1000; i++) make_safe(safety, i % 20 ? input_with({0, 0, 2}) : unanswered, kTick);
  EXPECT_FALSE(safety.is_lost);
  EXPECT_NEAR(safety.passivity.held_output.force.z, 2, 1e-9);
}

// One long tick of a stalled loop does not count as a lost device.
TEST(Safety, StalledLoopKeepsDevice) {
  Safety safety = started();
  SafetyInput late = input_with({0, 0, 2});
  late.answered = false;
  make_safe(safety, late, 3.0);
  EXPECT_FALSE(safety.is_lost);
  for (int i = 0; i < 5; i++) make_safe(safety, late, 3.0);  // a device that blocks and never answers
  EXPECT_TRUE(safety.is_lost);
}

/// Generator of arbitrary numbers, including invalid ones.
struct Garbage {
  std::mt19937_64 random{7};
  double number() {
    constexpr double kOdd[] = {0, kNan, kInf, -kInf, 1e9, -1e9, 1e308, -1e308, 1e-320, 1};
    const auto pick = random() % 20;
    if (pick < std::size(kOdd)) return kOdd[pick];
    return std::ldexp(double(random() % 2000) - 1000, int(random() % 40) - 30);
  }
  Vec3d vector() { return {number(), number(), number()}; }
  contact::Pose pose() {
    const auto pick = random() % 40;
    if (pick == 0) return {.position = vector(), .axes = {{vector(), vector(), vector()}}};
    if (pick == 1) return {.position = vector(), .axes = {}};
    return {.position = {1e-4 * double(random() % 100), 0, 0},
            .axes = rotation({0, 1e-2 * double(random() % 300), 0})};
  }
  double time() { return random() % 3 ? kTick : random() % 3 ? 0.05 : number(); }
};

// Arbitrary input of model and device never exceeds force limit or slew rate.
TEST(Safety, RandomInputStaysWithinLimits) {
  Garbage garbage;
  Safety safety = started();
  SafetyInput input;
  DeviceOutput before;
  const SafetyParams& p = safety.params;
  std::uint64_t haptic = 0;
  for (int i = 0; i < 100000; i++) {
    if (garbage.random() % 4 == 0) input.wanted = {garbage.vector(), garbage.vector(), garbage.number()};
    input.hand = {.pose = garbage.pose(), .velocity = garbage.vector(), .angular_velocity = garbage.vector()};
    input.age = garbage.random() % 500 ? 0 : garbage.number();
    input.answered = garbage.random() % 50 != 0;
    const DeviceOutput out = make_safe(safety, input, garbage.time()).value();
    ASSERT_TRUE(is_finite(out)) << i;
    ASSERT_LE(norm(out.force), p.force * (1 + 1e-12)) << i;
    ASSERT_LE(norm(out.torque), p.torque * (1 + 1e-12)) << i;
    ASSERT_LE(std::abs(out.grip_force), p.grip_force) << i;
    const double max_change = 2 * kTick / p.rise * (1 + 1e-9);
    ASSERT_LE(safety.is_lost ? 0 : norm(out.force - before.force), p.force * max_change) << i;
    ASSERT_LE(safety.is_lost ? 0 : norm(out.torque - before.torque), p.torque * max_change) << i;
    ASSERT_LE(safety.is_lost ? 0 : std::abs(out.grip_force - before.grip_force), p.grip_force * max_change)
        << i;
    haptic += norm(out.force) > 0.1;
    before = out;
    if (safety.start != SoftStart::kFull || safety.is_lost) {  // restart
      safety.is_lost = false, safety.unanswered_time = 0;
      safety.start = SoftStart::kFull, safety.gain = 1;
    }
  }
  EXPECT_GT(haptic, 20000u);  // the force was not always zero
  const SafetyCounts& c = safety.counts;
  for (const std::uint64_t count : {c.not_finite, c.silent, c.damped, c.slewed, c.saturated, c.jumped})
    EXPECT_GT(count, 10u);
}

// The sum of two counts adds every field.
TEST(Safety, CountsAddUp) {
  const SafetyCounts a{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, sum = a + a;
  EXPECT_EQ(sum.ticks, 2u);
  EXPECT_EQ(sum.waiting, 8u);
  EXPECT_EQ(sum.lost, 18u);
  EXPECT_EQ(sum.jumped, 20u);
}

}  // namespace
}  // namespace turgor::haptics

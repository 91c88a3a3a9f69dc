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

/// A chain whose soft start is over.
Safety begun(SafetyParams params = {}) {
  params.ramp = kTick;
  Safety safety = make_safety(kArm, params);
  for (int i = 0; i < 10; i++) make_safe(safety, {}, kTick);
  EXPECT_EQ(safety.start, SoftStart::kFull);
  safety.counts = {};
  return safety;
}

Asked asking(Vec3d force, double age = 0) {
  Asked asked;
  asked.wanted.force = force;
  asked.age = age;
  return asked;
}

/// What is felt after the same was asked for so many ticks.
DeviceOutput after(Safety& safety, const Asked& asked, int ticks) {
  SafeOutput out;
  for (int i = 0; i < ticks; i++) out = make_safe(safety, asked, kTick);
  return out.value();
}

TEST(safety, a_force_that_is_small_and_slow_is_felt_as_it_is) {
  Safety safety = begun();
  for (int i = 0; i < 1000; i++) {
    const Vec3d force{2 * std::sin(0.01 * i), 0, 1 - std::cos(0.02 * i)};
    EXPECT_LT(norm(make_safe(safety, asking(force), kTick).value().force - force), 1e-12);
  }
  const SafetyCounts& c = safety.counts;
  EXPECT_EQ(c.not_finite + c.silent + c.waiting + c.ramping + c.damped + c.slewed + c.saturated + c.lost, 0u);
  EXPECT_EQ(c.ticks, 1000u);
}

TEST(safety, what_is_not_finite_is_not_felt) {
  for (const double wrong : {kNan, kInf, -kInf}) {
    Safety safety = begun();
    EXPECT_EQ(norm(after(safety, asking({1, wrong, 0}), 3).force), 0);
    Asked asked;
    asked.wanted.torque.z = wrong;
    EXPECT_EQ(norm(after(safety, asked, 3).torque), 0);
    EXPECT_EQ(safety.counts.not_finite, 6u);
  }
}

TEST(safety, a_loop_that_begins_inside_a_body_feels_nothing_until_it_left) {
  Safety safety = make_safety(kArm, {});
  EXPECT_EQ(norm(after(safety, asking({0, 0, 3}), 5000).force), 0);
  EXPECT_EQ(safety.counts.waiting, 5000u);
  after(safety, asking({}), safety.params.calm_ticks);
  EXPECT_EQ(safety.start, SoftStart::kRamping);
}

TEST(safety, after_that_the_force_rises_evenly_over_the_ramp) {
  Safety safety = make_safety(kArm, {});
  after(safety, asking({}), 3);
  EXPECT_NEAR(after(safety, asking({0, 0, 3}), 250).force.z, 0.75, 1e-9);
  EXPECT_NEAR(after(safety, asking({0, 0, 3}), 500).force.z, 2.25, 1e-9);
  EXPECT_NEAR(after(safety, asking({0, 0, 3}), 251).force.z, 3, 1e-9);
  EXPECT_EQ(safety.start, SoftStart::kFull);
}

TEST(safety, a_touch_that_is_not_calm_for_long_enough_does_not_begin) {
  Safety safety = make_safety(kArm, {});
  for (int i = 0; i < 100; i++) make_safe(safety, asking({0, 0, i % 3 ? 0 : 1.0}), kTick);
  EXPECT_EQ(safety.start, SoftStart::kWaiting);
}

TEST(safety, a_hand_that_jumped_is_met_softly) {
  Safety safety = begun();
  Asked asked = asking({0, 0, 2});
  for (int i = 0; i < 100; i++) {  // at 2 m/s, as fast as hands are
    asked.hand.pose.position.x += 0.002;
    make_safe(safety, asked, kTick);
  }
  EXPECT_EQ(safety.counts.jumped, 0u);
  EXPECT_EQ(safety.start, SoftStart::kFull);
  asked.hand.pose.position.x += 0.05;
  EXPECT_EQ(norm(after(safety, asked, 50).force), 0);  // inside a body at once: nothing until it left
  EXPECT_EQ(safety.counts.jumped, 1u);
  EXPECT_EQ(safety.start, SoftStart::kWaiting);
}

TEST(safety, limits_that_are_no_limits_are_none_and_no_slope_is_steeper_than_a_millisecond) {
  for (const double wrong : {kNan, -1.0, 0.0}) {
    Safety safety = begun({.force = wrong, .torque = wrong, .rise = wrong});
    EXPECT_EQ(norm(after(safety, asking({0, 0, 5}), 100).force), 0) << wrong;
  }
  for (const double steep : {kNan, -1.0, 0.0, 1e-9}) {
    Safety safety = begun({.rise = steep});
    EXPECT_NEAR(make_safe(safety, asking({0, 0, 10}), 0.5e-3).value().force.z, 5, 1e-9) << steep;
  }
  EXPECT_EQ(make_safety({.force = kNan}, {}).params.force, 0);
}

TEST(safety, energy_that_was_given_away_is_taken_back) {
  Safety safety = begun();
  Asked asked = asking({0, 0, 1});
  asked.hand.velocity = {0, 0, 0.1};
  for (int i = 0; i < 100; i++) {  // pushed along: 1 N · 0.1 m/s
    asked.hand.pose.position.z = 1e-4 * i;
    make_safe(safety, asked, kTick);
  }
  EXPECT_LT(safety.passivity.lowest, -1e-4);
  EXPECT_GT(safety.counts.damped, 90u);
  EXPECT_NEAR(safety.passivity.haptic.force.z, 1 - 0.1 * safety.params.passivity.damping, 0.05);
}

TEST(safety, a_jump_becomes_a_slope) {
  Safety safety = begun();
  for (int i = 1; i <= 5; i++)
    EXPECT_NEAR(make_safe(safety, asking({6, 8, 0}), kTick).value().force.y, 0.8 * 2 * i, 1e-9);
  EXPECT_EQ(safety.counts.slewed, 4u);  // the fifth arrives
}

TEST(safety, a_tick_that_comes_late_may_not_jump_farther_than_two) {
  Safety safety = begun();
  EXPECT_NEAR(make_safe(safety, asking({10, 0, 0}), 0.5).value().force.x, 4, 1e-9);
}

TEST(safety, the_vector_is_saturated_and_keeps_its_direction) {
  Safety safety = begun();
  const DeviceOutput haptic = after(safety, asking({30, -40, 0}), 50);
  EXPECT_NEAR(haptic.force.x, 6, 1e-9);
  EXPECT_NEAR(haptic.force.y, -8, 1e-9);
  EXPECT_EQ(safety.counts.saturated, 45u);  // all but the five on the way
}

TEST(safety, the_smaller_limit_of_user_and_device_holds) {
  for (const double user : {3.0, 500.0}) {
    Safety safety = begun({.force = user, .torque = user});
    EXPECT_NEAR(norm(after(safety, asking({0, 0, 1e9}), 100).force), std::min(user, 12.0), 1e-9);
    EXPECT_NEAR(safety.params.torque, std::min(user, 0.4), 1e-12);
  }
  Safety three_axes = make_safety({.force = 5}, {});
  EXPECT_EQ(three_axes.params.torque, 0);
}

TEST(safety, a_model_that_falls_silent_becomes_damping_and_then_nothing) {
  Safety safety = begun();
  after(safety, asking({0, 0, 2}, 0.09), 100);
  EXPECT_NEAR(safety.passivity.haptic.force.z, 2, 1e-9);
  Asked silent = asking({0, 0, 2}, 0.11);
  silent.hand.velocity = {0, 0.1, 0};
  EXPECT_NEAR(after(safety, silent, 50).force.y, -0.1 * safety.params.silent_damping, 1e-9);
  EXPECT_NEAR(safety.passivity.haptic.force.z, 0, 1e-9);
  EXPECT_NEAR(after(safety, silent, 700).force.y, -0.05 * safety.params.silent_damping, 2e-3);
  EXPECT_EQ(norm(after(safety, silent, 300).force), 0);
  EXPECT_EQ(safety.counts.silent, 1050u);
  after(safety, asking({0, 0, 2}), 100);  // it speaks again: softly
  EXPECT_EQ(safety.start, SoftStart::kWaiting);
  after(safety, asking({0, 0, 2}, kNan), 1);
  EXPECT_EQ(safety.counts.silent, 1051u);
}

TEST(safety, a_device_that_is_lost_gets_nothing_and_stays_off) {
  Safety safety = begun();
  after(safety, asking({0, 0, 2}), 100);
  Asked gone = asking({0, 0, 2});
  gone.answered = false;
  after(safety, gone, 49);
  EXPECT_FALSE(safety.is_lost);
  EXPECT_EQ(norm(after(safety, gone, 5).force), 0);
  EXPECT_TRUE(safety.is_lost);
  EXPECT_EQ(norm(after(safety, asking({0, 0, 2}), 1000).force), 0);
  EXPECT_GT(safety.counts.lost, 1000u);
}

TEST(safety, an_answer_that_is_missed_once_is_no_loss) {
  Safety safety = begun();
  Asked gone = asking({0, 0, 2});
  gone.answered = false;
  for (int i = 0; i < 1000; i++) make_safe(safety, i % 20 ? asking({0, 0, 2}) : gone, kTick);
  EXPECT_FALSE(safety.is_lost);
  EXPECT_NEAR(safety.passivity.haptic.force.z, 2, 1e-9);
}

TEST(safety, a_loop_that_stalled_does_not_take_its_device_for_lost) {
  Safety safety = begun();
  Asked late = asking({0, 0, 2});
  late.answered = false;
  make_safe(safety, late, 3.0);
  EXPECT_FALSE(safety.is_lost);
  for (int i = 0; i < 5; i++) make_safe(safety, late, 3.0);  // a device that makes it wait, and never answers
  EXPECT_TRUE(safety.is_lost);
}

/// Whatever numbers there are.
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

TEST(safety, whatever_a_model_and_a_device_say_the_force_stays_within_limit_and_slope) {
  Garbage garbage;
  Safety safety = begun();
  Asked asked;
  DeviceOutput before;
  const SafetyParams& p = safety.params;
  std::uint64_t haptic = 0;
  for (int i = 0; i < 100000; i++) {
    if (garbage.random() % 4 == 0) asked.wanted = {garbage.vector(), garbage.vector(), garbage.number()};
    asked.hand = {.pose = garbage.pose(), .velocity = garbage.vector(), .angular_velocity = garbage.vector()};
    asked.age = garbage.random() % 500 ? 0 : garbage.number();
    asked.answered = garbage.random() % 50 != 0;
    const DeviceOutput out = make_safe(safety, asked, garbage.time()).value();
    ASSERT_TRUE(is_finite(out)) << i;
    ASSERT_LE(norm(out.force), p.force * (1 + 1e-12)) << i;
    ASSERT_LE(norm(out.torque), p.torque * (1 + 1e-12)) << i;
    ASSERT_LE(std::abs(out.grip_force), p.grip_force) << i;
    const double part = 2 * kTick / p.rise * (1 + 1e-9);
    ASSERT_LE(safety.is_lost ? 0 : norm(out.force - before.force), p.force * part) << i;
    ASSERT_LE(safety.is_lost ? 0 : norm(out.torque - before.torque), p.torque * part) << i;
    ASSERT_LE(safety.is_lost ? 0 : std::abs(out.grip_force - before.grip_force), p.grip_force * part) << i;
    haptic += norm(out.force) > 0.1;
    before = out;
    if (safety.start != SoftStart::kFull || safety.is_lost) {  // on with it
      safety.is_lost = false, safety.unheard = 0;
      safety.start = SoftStart::kFull, safety.gain = 1;
    }
  }
  EXPECT_GT(haptic, 20000u);  // it was not all zero
  const SafetyCounts& c = safety.counts;
  for (const std::uint64_t count : {c.not_finite, c.silent, c.damped, c.slewed, c.saturated, c.jumped})
    EXPECT_GT(count, 10u);
}

TEST(safety, counts_add_up_link_by_link) {
  const SafetyCounts a{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, sum = a + a;
  EXPECT_EQ(sum.ticks, 2u);
  EXPECT_EQ(sum.waiting, 8u);
  EXPECT_EQ(sum.lost, 18u);
  EXPECT_EQ(sum.jumped, 20u);
}

}  // namespace
}  // namespace turgor::haptics

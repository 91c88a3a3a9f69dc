#include "turgor/haptics/z_width.hpp"

#include <cstdio>
#include <limits>

#include <gtest/gtest.h>

namespace turgor::haptics {
namespace {

WallTrial trial(double stiffness, double damping = 0, bool controller = false) {
  WallTrial t;
  t.stiffness = stiffness;
  t.damping = damping;
  t.controller = controller;
  return t;
}

/// Between stable and not, by halving [N/m].
double stiffest(WallTrial t) {
  double stable = 10, not_stable = 1e6;
  while (not_stable > 1.02 * stable) {
    t.stiffness = std::sqrt(stable * not_stable);
    (press_wall(t).stable ? stable : not_stable) = t.stiffness;
  }
  return stable;
}

/// An arm without dry friction and encoder, so that the theory is that of a linear system.
WallTrial linear(double frame_rate) {
  WallTrial t = trial(0);
  t.arm.coulomb = t.arm.encoder = 0;
  t.arm.viscous = 2;
  t.hand_damping = 0.2;
  t.depth = 0.02;
  t.arm.force = 100;
  t.answer = WallAnswer::kHeld;
  t.frame_rate = frame_rate;
  t.seconds = 6;
  return t;
}

TEST(z_width, a_wall_below_colgates_bound_is_stable_and_one_far_above_is_not) {
  const WallTrial t = trial(0);
  const double bound = colgate_stiffness(t.arm.viscous, 0, 1 / t.arm.rate);
  EXPECT_TRUE(press_wall(trial(0.9 * bound)).stable);
  EXPECT_FALSE(press_wall(trial(40 * bound)).stable);
}

TEST(z_width, walls_rest_up_to_what_theory_says_at_every_rate_damping_and_delay) {
  struct Case {
    double rate, damping;
    int delay;
  };
  for (const auto& [rate, damping, delay] :
       {Case{1000, 0, 0}, {500, 0, 0}, {250, 0, 0}, {1000, 2, 0}, {1000, 6, 0}, {1000, 0, 1}, {1000, 2, 3}}) {
    WallTrial t = linear(rate);
    t.damping = damping;
    t.arm.delay = delay;
    const double found = stiffest(t), b = t.arm.viscous + t.hand_damping;
    const double theory = resting_stiffness(b, damping, 1 / rate, delay * 1e-3);
    std::printf("%4.0f Hz, B = %g, %d late: %.0f N/m, theory %.0f N/m\n", rate, damping, delay, found,
                theory);
    EXPECT_GT(found, 0.95 * colgate_stiffness(t.arm.viscous, damping, 1 / rate) / (1 + 2 * delay));
    EXPECT_NEAR(found / theory, 1, 0.15);
  }
}

TEST(z_width, the_controller_holds_walls_that_shake_without_it) {
  for (const double stiffness : {12000.0, 20000.0}) {
    const WallVerdict without = press_wall(trial(stiffness)), with = press_wall(trial(stiffness, 0, true));
    std::printf("%5.0f N/m: %.1f mm/s without, %.1f mm/s with\n", stiffness, 1e3 * without.speed,
                1e3 * with.speed);
    EXPECT_FALSE(without.stable);
    EXPECT_LT(with.speed, 0.5 * without.speed);
  }
}

TEST(z_width, a_force_held_for_a_frame_shakes_where_the_contact_of_the_last_frame_does_not) {
  WallTrial t = trial(800);
  t.frame_rate = 30;
  t.answer = WallAnswer::kHeld;
  EXPECT_FALSE(press_wall(t).stable);
  t.answer = WallAnswer::kLocal;
  EXPECT_TRUE(press_wall(t).stable);
}

TEST(z_width, a_trial_gives_the_same_bits_twice) {
  const WallVerdict a = press_wall(trial(9000, 5)), b = press_wall(trial(9000, 5));
  EXPECT_EQ(a.late, b.late);
  EXPECT_EQ(a.lowest_energy, b.lowest_energy);
}

TEST(z_width, bounds_are_those_of_the_papers) {
  EXPECT_DOUBLE_EQ(colgate_stiffness(0.5, 0, 1e-3), 1000);  // Colgate: K = 1000 N/m, T = 1 ms needs b > 0.5
  EXPECT_DOUBLE_EQ(colgate_stiffness(1, -0.25, 1e-3), 1500);
  EXPECT_DOUBLE_EQ(resting_stiffness(1, 2, 1e-3, 1e-3), 2000);
  EXPECT_DOUBLE_EQ(quantized_stiffness(0.05, 10e-6), 10000);
  EXPECT_EQ(quantized_stiffness(0.05, 0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace turgor::haptics

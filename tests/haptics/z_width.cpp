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

/// Largest stable stiffness, found by bisection on a logarithmic scale [N/m].
double stiffest(WallTrial t) {
  double stable = 10, not_stable = 1e6;
  while (not_stable > 1.02 * stable) {
    t.stiffness = std::sqrt(stable * not_stable);
    (press_wall(t).stable ? stable : not_stable) = t.stiffness;
  }
  return stable;
}

/// An arm without dry friction and encoder, so that linear theory applies.
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

// A wall below Colgate's bound is stable, and one far above it is not.
TEST(ZWidth, ColgateBoundSeparatesStability) {
  const WallTrial t = trial(0);
  const double bound = colgate_stiffness(t.arm.viscous, 0, 1 / t.arm.rate);
  EXPECT_TRUE(press_wall(trial(0.9 * bound)).stable);
  EXPECT_FALSE(press_wall(trial(40 * bound)).stable);
}

// The largest stable stiffness matches theory for several rates, dampings and delays.
TEST(ZWidth, StableStiffnessMatchesTheory) {
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

// The controller at least halves the oscillation of unstable walls.
TEST(ZWidth, ControllerHalvesOscillation) {
  for (const double stiffness : {12000.0, 20000.0}) {
    const WallVerdict without = press_wall(trial(stiffness)), with = press_wall(trial(stiffness, 0, true));
    std::printf("%5.0f N/m: %.1f mm/s without, %.1f mm/s with\n", stiffness, 1e3 * without.speed,
                1e3 * with.speed);
    EXPECT_FALSE(without.stable);
    EXPECT_LT(with.speed, 0.5 * without.speed);
  }
}

// A force held for a frame is unstable where a local contact model is stable.
TEST(ZWidth, LocalContactBeatsHeldForce) {
  WallTrial t = trial(800);
  t.frame_rate = 30;
  t.answer = WallAnswer::kHeld;
  EXPECT_FALSE(press_wall(t).stable);
  t.answer = WallAnswer::kLocal;
  EXPECT_TRUE(press_wall(t).stable);
}

// Two equal trials give the same result.
TEST(ZWidth, TrialIsDeterministic) {
  const WallVerdict a = press_wall(trial(9000, 5)), b = press_wall(trial(9000, 5));
  EXPECT_EQ(a.late, b.late);
  EXPECT_EQ(a.lowest_energy, b.lowest_energy);
}

// The stability bounds match the values of the papers.
TEST(ZWidth, BoundsMatchPapers) {
  EXPECT_DOUBLE_EQ(colgate_stiffness(0.5, 0, 1e-3), 1000);  // Colgate: K = 1000 N/m, T = 1 ms needs b > 0.5
  EXPECT_DOUBLE_EQ(colgate_stiffness(1, -0.25, 1e-3), 1500);
  EXPECT_DOUBLE_EQ(resting_stiffness(1, 2, 1e-3, 1e-3), 2000);
  EXPECT_DOUBLE_EQ(quantized_stiffness(0.05, 10e-6), 10000);
  EXPECT_EQ(quantized_stiffness(0.05, 0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace turgor::haptics

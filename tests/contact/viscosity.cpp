#include "turgor/contact/viscosity.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/contact/half_space.hpp"
#include "turgor/contact/touch.hpp"

namespace turgor::contact {
namespace {

constexpr double kRadius = 5e-3;
const HalfSpace kSoft{.side = 9};

/// A sphere that holds the center of a half space, so that its response is linear.
struct Grip {
  sfem::Patch patch = half_space_patch(kSoft);
  std::vector<Tool> tools{{Sphere{kRadius}, 0.3}};
  TouchState state;
  std::vector<ToolForce> forces{1};
  Vec3d at{0, 0, kRadius - 0.2e-3};

  explicit Grip(const Prony& viscosity) : state(make_touch_state(patch, 1, {.viscosity = viscosity})) {
    move({}, 0, false);
    // Forget the history of the grip: the held points start at rest.
    for (int i = 0; i < 100; i++) move({}, 1e6, true);
  }
  Vec3d move(Vec3d by, double dt, bool hold = true) {
    at += by;
    const std::vector<ToolPose> poses{{{at, {}}, hold}};
    solve_touch_tick(patch, state, tools, poses, dt, forces);
    return forces[0].force;
  }
};

// A sudden move is stiffer by exactly 1 + p; the force then relaxes as the closed form.
TEST(Viscosity, StepResponseMatchesClosedForm) {
  const Prony law = one_pair(1.5, 0.1);
  Grip soft({}), stiff(law);
  const Vec3d step{1e-4, 0, 2e-4};
  const Vec3d soft_before = soft.forces[0].force, stiff_before = stiff.forces[0].force;
  EXPECT_LT(norm(stiff_before - soft_before), 1e-6 * norm(soft_before)) << "at rest both are elastic";
  const Vec3d elastic = soft.move(step, 0) - soft_before;
  const Vec3d sudden = stiff.move(step, 0) - stiff_before;
  EXPECT_LT(norm(sudden - 2.5 * elastic), 1e-9 * norm(elastic));
  const double dt = 1e-4;
  double worst = 0;
  for (int i = 1; i <= 5000; i++) {
    const Vec3d now = stiff.move({}, dt) - stiff_before;
    const double exact = 1 + 1.5 * std::exp(-i * dt / law.pairs[0].time);
    worst = std::max(worst, norm(now - exact * elastic) / norm(elastic));
  }
  EXPECT_LT(worst, 0.5 * dt / law.pairs[0].time * 1.5) << "implicit Euler is of first order";
  EXPECT_LT(norm(stiff.move({}, dt) - stiff_before - (1 + 1.5 * std::exp(-5)) * elastic),
            1e-3 * norm(elastic));
}

// Under a constant force, the material creeps as the closed form.
TEST(Viscosity, CreepMatchesClosedForm) {
  // u(t) = u_inf (1 − p/(1+p) exp(−t/(τ (1+p)))) for the law alone, with a scalar Ξ.
  const Prony law = one_pair(2, 0.05);
  const double xi = 3e-3, f = 0.4, dt = 1e-4;
  ViscousHistory history{.pairs = {{{.v = {{}}, .phi = {{}}, .far = {}}}}, .count = 1};
  const PairHistory& pair = history.pairs[0];
  double worst = 0;
  for (int i = 1; i <= 6000; i++) {
    const ViscousTick tick = viscous_tick(law, dt);
    const std::vector<Vec3d> u{{(xi * f + tick.p[0] * pair.v[0].x) / (1 + tick.total), 0, 0}},
        force{{f, 0, 0}};
    remember(tick, u, force, history);
    const double exact = xi * f * (1 - 2.0 / 3 * std::exp(-i * dt / (law.pairs[0].time * 3)));
    worst = std::max(worst, std::abs(u[0].x - exact) / (xi * f));
    EXPECT_NEAR(pair.v[0].x, xi * pair.phi[0].x, 1e-15) << "v = Xi phi";
  }
  EXPECT_LT(worst, 2e-3);
}

// Without new forces, the history of far vertices decays as that of the patch.
TEST(Viscosity, FarHistoryDecaysAsNearHistory) {
  const Prony law = one_pair(2, 0.05);
  ViscousHistory history{.pairs = {{{.v = {{}}, .phi = {{1, 0, 0}}, .far = {{0, {1, 0, 0}}}}}}, .count = 1};
  for (int i = 0; i < 200; i++) {
    const std::vector<Vec3d> u{{}}, force{{}};
    remember(viscous_tick(law, 1e-3), u, force, history);
    EXPECT_NEAR(history.pairs[0].phi[0].x, history.far_factor[0][0], 1e-13);
  }
  EXPECT_LT(history.far_factor[0][0], 0.3);
}

// Three pairs follow the closed form of ramp and hold within 1 % at ramps of 0.05, 0.5 and 5 s.
TEST(Viscosity, ThreePairsMatchRampAndHold) {
  const Prony law{{{{0.8, 0.1}, {0.5, 1}, {0.3, 10}}}};
  const Vec3d whole{0.5e-4, 0, 1e-4};
  Grip soft({});
  const Vec3d soft_before = soft.forces[0].force, elastic = soft.move(whole, 0) - soft_before;
  for (const double ramp : {0.05, 0.5, 5.0}) {
    Grip grip(law);
    const Vec3d before = grip.forces[0].force;
    constexpr double kTick = 1e-3;
    const int ticks = int(std::lround(ramp / kTick)), hold = 4 * ticks;
    double worst = 0, peak = 0;
    for (int i = 1; i <= ticks + hold; i++) {
      const Vec3d now = grip.move(i <= ticks ? whole / ticks : Vec3d{}, kTick) - before;
      const double t = i * kTick, up = std::min(t, ramp), held = std::max(0.0, t - ramp);
      double exact = up / ramp;
      for (const PronyPair& pair : law.pairs)
        exact += pair.ratio * pair.time / ramp * -std::expm1(-up / pair.time) * std::exp(-held / pair.time);
      worst = std::max(worst, norm(now - exact * elastic) / norm(elastic));
      peak = std::max(peak, exact);
    }
    EXPECT_LT(worst, 0.01 * peak) << ramp;
  }
}

// The far memory of three pairs decays as that of the patch, although the pairs act on each other.
TEST(Viscosity, FarHistoryOfThreePairsDecaysAlike) {
  const Prony law{{{{2, 0.05}, {1, 0.3}, {0.5, 2}}}};
  const Vec3d start[] = {{1, 0, 0}, {-0.4, 0, 0}, {0.7, 0, 0}};
  ViscousHistory history{.pairs = {}, .count = 3};
  for (std::size_t i = 0; i < 3; i++)
    history.pairs[i] = {.v = {{}}, .phi = {start[i]}, .far = {{0, start[i]}}};
  for (int n = 0; n < 500; n++) {
    const std::vector<Vec3d> u{{}}, force{{}};
    remember(viscous_tick(law, 1e-3), u, force, history);
    for (std::size_t i = 0; i < 3; i++) {
      double far = 0;
      for (std::size_t j = 0; j < 3; j++) far += history.far_factor[i][j] * start[j].x;
      EXPECT_NEAR(history.pairs[i].phi[0].x, far, 1e-12) << i;
    }
  }
}

// Pairs that come into use add no force yet, and a later step meets them all. Without the pairs the force is
// elastic again.
TEST(Viscosity, ChangedPairsBeginRelaxed) {
  const Prony law{{{{0.8, 0.1}, {0.5, 1}, {0.3, 10}}}};
  Grip grip({});
  const Vec3d step{1e-4, 0, 2e-4};
  const Vec3d rest = grip.forces[0].force, elastic = grip.move(step, 0) - rest;
  const auto change = [&](const Prony& to) {
    change_pairs(grip.state.params.viscosity, to, grip.state.u, grip.state.force, grip.state.history);
    grip.state.params.viscosity = to;
  };
  change(law);
  EXPECT_LT(norm(grip.move({}, 1e-3) - rest - elastic), 1e-9 * norm(elastic)) << "at the same position";
  EXPECT_LT(norm(grip.move(step, 0) - rest - (2 + total_ratio(law)) * elastic), 1e-9 * norm(elastic));
  change(one_pair(0.8, 0.1));
  EXPECT_LT(norm(grip.move({}, 0) - rest - 2.8 * elastic), 1e-9 * norm(elastic))
      << "memory of the first stays";
  change({});
  EXPECT_LT(norm(grip.move({}, 0) - rest - 2 * elastic), 1e-9 * norm(elastic));
}

// v = Ξ φ holds for each pair in use while pairs come and go, and the far memory decays as that of the patch.
TEST(Viscosity, ChangedPairsKeepTheirMemoryForce) {
  const PronyPair a{2, 0.05}, b{1, 0.3}, c{0.5, 2};
  const double xi = 3e-3;
  ViscousHistory history{.pairs = {{{.v = {{xi, 0, 0}}, .phi = {{1, 0, 0}}, .far = {{0, {1, 0, 0}}}}}},
                         .count = 1};
  Prony now{{{a, {}, {}}}};
  std::vector<Vec3d> u{{}};
  const std::vector<Vec3d> none{{}};
  for (const Prony& next :
       {Prony{{{a, b, c}}}, Prony{{{a, b, {}}}}, Prony{{{a, {}, {}}}}, Prony{{{c, b, a}}}}) {
    for (int n = 0; n < 40; n++) {
      const ViscousTick tick = viscous_tick(now, 1e-3);
      u[0] = remembered_displacement(tick, history, 0);
      remember(tick, u, none, history);
    }
    change_pairs(now, next, u, none, history);
    now = next;
    ASSERT_EQ(history.count, pair_count(next));
    for (std::size_t i = 0; i < std::size_t(history.count); i++) {
      EXPECT_NEAR(history.pairs[i].v[0].x, xi * history.pairs[i].phi[0].x, 1e-15) << i;
      EXPECT_NEAR(history.far_factor[i][0], history.pairs[i].phi[0].x, 1e-12) << i;
      EXPECT_GT(history.far_factor[i][0], 0.1) << i;
    }
  }
}

// Pairs that are not in use have no memory.
TEST(Viscosity, UnusedPairsHaveNoMemory) {
  const sfem::Patch patch = half_space_patch(kSoft);
  for (int count = 0; count <= kMostPronyPairs; count++) {
    Prony law;
    for (int i = 0; i < count; i++) law.pairs[std::size_t(i)] = {0.5, 0.1};
    const TouchState state = make_touch_state(patch, 1, {.viscosity = law});
    for (int i = 0; i < kMostPronyPairs; i++)
      EXPECT_EQ(state.history.pairs[std::size_t(i)].v.capacity() > 0, i < count) << count;
  }
}

// Closed random paths always dissipate energy.
TEST(Viscosity, RandomPathsDissipateEnergy) {
  std::mt19937 random(3);
  std::normal_distribution<double> number;
  for (const double time : {0.003, 0.03, 0.3}) {
    Grip grip({{{{1, time}, {0.5, 4 * time}, {0.2, 16 * time}}}});
    const Vec3d start = grip.at;
    Vec3d before = grip.forces[0].force, velocity;
    double work = 0, size = 0;
    const auto move_by = [&](Vec3d by) {
      const Vec3d now = grip.move(by, 1e-3);
      work -= dot((now + before) / 2, by);
      size += std::abs(dot(now, by));
      before = now;
    };
    for (int tick = 0; tick < 4000; tick++) {
      velocity = 0.9 * velocity + Vec3d{number(random), number(random), number(random)} * 5e-6 -
                 (grip.at - start) * 0.02;
      move_by(velocity);
    }
    const Vec3d back = (start - grip.at) / 50;
    for (int i = 0; i < 50; i++) move_by(back);
    for (int i = 0; i < 3000; i++) move_by({});
    EXPECT_GT(work, 0) << time;
    EXPECT_GT(work, 1e-3 * size) << time;
  }
}

// Zero stiffening is exactly elastic.
TEST(Viscosity, ZeroStiffeningIsElastic) {
  Grip elastic({}), off(one_pair(0, 0.1));
  for (int i = 0; i < 100; i++)
    EXPECT_EQ(elastic.move({1e-6 * i, 0, 2e-6}, 1e-3), off.move({1e-6 * i, 0, 2e-6}, 1e-2));
}

// A fast press is stiffer than a slow one, and a slow one is elastic.
TEST(Viscosity, FastPressIsStiffer) {
  const auto press = [](const Prony& viscosity, double duration) {
    sfem::Patch patch = half_space_patch({.side = 13});
    const std::vector<Tool> tools{{Sphere{kRadius}, 0}};
    TouchState state = make_touch_state(patch, 1, {.viscosity = viscosity});
    std::vector<ToolForce> forces(1);
    for (int i = 1; i <= 200; i++) {
      const std::vector<ToolPose> poses{{{{0, 0, kRadius - 5e-6 * i}, {}}, false}};
      solve_touch_tick(patch, state, tools, poses, duration / 200, forces);
    }
    return forces[0].force.z;
  };
  const Prony law = one_pair(1, 0.1);
  const double elastic = press({}, 1);
  EXPECT_NEAR(press(law, 1000) / elastic, 1, 1e-3);
  EXPECT_NEAR(press(law, 1e-4) / elastic, 2, 2e-3);
  EXPECT_GT(press(law, 0.1) / elastic, 1.3);
}

}  // namespace
}  // namespace turgor::contact

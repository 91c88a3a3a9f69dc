// Chains alone resist without bound when they are stretched upright or pressed flat; tissue does not.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/rhombus_bodies.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {
namespace {

/// As a calibration to a liver of finite elements makes it: short sides, stiff springs.
constexpr ChainParams kStiff{.normal = 6, .tangential = 40, .decay = 3, .angle = 0.9, .side = 0.002};

Model model_of(const Params& params) {
  Surface surface = test::sphere(0.06, 3);
  return *build({std::move(surface.vertices), std::move(surface.triangles), {}}, params);
}

TouchForce tick(const Model& model, State& state, const TouchInput& input) {
  TouchForce force;
  touch(model, state, {&input, 1}, 1e-3, {&force, 1});
  return force;
}

TEST(RhombusTear, ten_thousand_random_grasps_are_finite_and_never_beyond_the_limit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(0, 1), sign(-1, 1);
  const Model models[] = {model_of({.chain = kStiff}), model_of({}),
                          model_of({.chain = kStiff, .viscosity = {2, 0.05}, .tear = 5})};
  int slips = 0;
  for (int grasp = 0; grasp < 10000; grasp++) {
    const Model& model = models[grasp % 3];
    State state = make_state(model, 1);
    const double depth = 0.001 + 0.02 * part(random), pull = 0.5 * part(random);
    const Vec3d aside{0.3 * sign(random), 0.3 * sign(random), 0};
    TouchInput in{.position = {0, 0, 0.065}, .radius = 0.005, .opening = 0.01};
    const auto expect_bounded = [&](const TouchForce& f) {
      ASSERT_TRUE(std::isfinite(norm(f.force)) && std::isfinite(f.squeeze));
      ASSERT_LE(norm(f.force), model.params.tear * (1 + 1e-12));
      ASSERT_LE(f.squeeze, model.params.tear);
      slips += f.slipped;
    };
    for (int i = 1; i <= 4; i++)
      in.position.z = 0.065 - depth * i / 4, expect_bounded(tick(model, state, in));
    for (in.grip = 0.25; in.grip <= 1; in.grip += 0.25)
      in.opening = 0.01 * (1 - in.grip), expect_bounded(tick(model, state, in));
    in.grip = 1;
    const Vec3d from = in.position;
    for (int i = 1; i <= 12; i++) {
      in.position = from + (Vec3d{0, 0, pull} + aside) * (i / 12.0);
      expect_bounded(tick(model, state, in));
    }
  }
  EXPECT_GT(slips, 1000) << "most are pulled farther than anything reaches";
}

TEST(RhombusTear, what_slips_out_is_felt_no_more_until_the_jaws_have_opened) {
  const Model model = model_of({.chain = kStiff, .tear = 20});
  State state = make_state(model, 1);
  TouchInput in{.position = {0, 0, 0.062}, .radius = 0.005, .opening = 0.01};
  tick(model, state, in);
  in.grip = 1, in.opening = 0;
  ASSERT_TRUE(tick(model, state, in).holding);
  double before = 0, steepest = 0;
  bool slipped = false;
  for (int i = 0; i < 400000 && !slipped; i++) {
    in.position.z += 1e-6;
    const TouchForce f = tick(model, state, in);
    slipped = f.slipped;
    if (slipped) break;
    EXPECT_TRUE(f.holding);
    steepest = std::max(steepest, std::abs(norm(f.force) - before) / 1e-6);
    before = norm(f.force);
  }
  ASSERT_TRUE(slipped);
  EXPECT_GT(before, 15) << "as much as it bears is felt before";
  EXPECT_LT(steepest, 1e6) << "N/m: the law has an end before its slope does";
  for (int i = 0; i < 5; i++) {
    const TouchForce f = tick(model, state, in);
    EXPECT_EQ(f.force, Vec3d{});
    EXPECT_FALSE(f.holding);
    EXPECT_FALSE(f.slipped) << "once";
  }
  in.grip = 0, in.opening = 0.01, in.position.z = 0.062;
  tick(model, state, in);
  in.grip = 1;
  EXPECT_TRUE(tick(model, state, in).holding) << "opened and closed again, it holds";
}

TEST(RhombusTear, a_press_beyond_the_limit_stays_there_and_says_so) {
  const Model model = model_of({.chain = kStiff, .tear = 2});
  State state = make_state(model, 1);
  double before = 0;
  bool yielded = false;
  for (double depth = 0; depth < 0.05; depth += 1e-4) {
    const TouchForce f = tick(model, state, {.position = {0, 0, 0.065 - depth}, .radius = 0.005});
    EXPECT_GE(norm(f.force), before - 1e-9);
    EXPECT_EQ(f.yielding, norm(f.force) > 2 - 1e-9) << depth;
    before = norm(f.force), yielded |= f.yielding;
  }
  EXPECT_TRUE(yielded);
  EXPECT_NEAR(before, 2, 1e-9);
}

}  // namespace
}  // namespace turgor::rhombus

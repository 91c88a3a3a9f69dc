// The force of tissue is limited, and chains reach the limit with a bounded slope.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/rhombus/bodies.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/rhombus/tissues.hpp"

namespace turgor::rhombus {
namespace {

/// Short sides and stiff springs.
constexpr ChainParams kStiff{
    .normal = 6, .tangential = 40, .decay = 3, .angle = 0.9, .side = 0.002, .stiffening = 4};

Model model_of(const Params& params) {
  Surface surface = test::sphere(0.06, 3);
  return *build({std::move(surface.vertices), std::move(surface.triangles), {}}, params);
}

TouchForce tick(const Model& model, State& state, const TouchInput& input) {
  TouchForce force;
  solve_touches(model, state, {&input, 1}, 1e-3, {&force, 1});
  return force;
}

/// A random grasp: a press, closing jaws, and a pull in a random direction.
struct Grasp {
  double depth, pull, radius;
  Vec3d sideways;
};

// The forces of 100 000 random grasps stay below 50 N, on a bounded slope.
TEST(RhombusTear, RandomGraspsAreBounded) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> fraction(0, 1), sign(-1, 1);
  const Model models[] = {
      model_of({.chain = tissues()[0].chain}), model_of({.chain = find_tissue("liver-porcine")->chain}),
      model_of({.chain = kStiff}), model_of({}),
      model_of({.chain = chain_of_modulus(4e4), .viscosity = one_pair(2, 0.05), .tear = 5})};
  State state = make_state(models[0], 1);  // all models have the same surface
  int slips = 0;
  double strongest = 0, steepest = 0;
  for (int grasp = 0; grasp < 100000; grasp++) {
    const Model& model = models[grasp % 5];
    state.touches[0] = {};
    const Grasp g{0.001 + 0.02 * fraction(random),
                  0.5 * fraction(random),
                  0.001 + 0.014 * fraction(random),
                  {0.3 * sign(random), 0.3 * sign(random), 0}};
    TouchInput in{.position = {0, 0, 0.06 + g.radius}, .radius = g.radius, .opening = 0.01};
    TouchForce before;
    const auto check = [&](const TouchForce& f, double distance) {
      ASSERT_TRUE(std::isfinite(norm(f.force)) && std::isfinite(f.squeeze));
      ASSERT_LE(std::max(norm(f.force), f.squeeze), model.params.tear * (1 + 1e-12));
      strongest = std::max(strongest, norm(f.force)), slips += f.slipped + before.slipped;
      if (!before.slipped && !f.slipped && !f.yielding)
        steepest = std::max(steepest, norm(f.force - before.force) / distance);
      before = f;
    };
    const double distance = 1e-5;  // a second tick after this distance measures the slope
    in.position.z -= g.depth;
    before = tick(model, state, in);
    in.position.z -= distance;
    check(tick(model, state, in), distance);
    in.grip = 1, in.opening = 0.01 * fraction(random);
    before = tick(model, state, in);
    const Vec3d from = in.position, to = from + Vec3d{0, 0, g.pull} + g.sideways;
    for (const double progress : {0.03, 0.2, 1.0}) {
      if (before.slipped) break;
      in.position = from + (to - from) * progress;
      before = tick(model, state, in);
      in.position += normalized(to - from) * distance;
      check(tick(model, state, in), distance);
    }
  }
  std::printf("grasps: %d slips, %.1f N at most, %.0f N/m at most\n", slips, strongest, steepest);
  EXPECT_GT(slips, 1000) << "most pulls exceed every chain's reach";
  EXPECT_LT(strongest, 50) << "N";
  EXPECT_LT(steepest, 1e5) << "N/m";
}

// Tissue that has slipped out has no force until the jaws have opened.
TEST(RhombusTear, SlippedTissueHasNoForce) {
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
  EXPECT_GT(before, 15) << "the force nears the limit before the slip";
  EXPECT_LT(steepest, 1e5) << "N/m: the limit is reached on a bounded slope";
  for (int i = 0; i < 5; i++) {
    const TouchForce f = tick(model, state, in);
    EXPECT_EQ(f.force, Vec3d{});
    EXPECT_FALSE(f.holding);
    EXPECT_FALSE(f.slipped) << "reported once";
  }
  in.grip = 0, in.opening = 0.01, in.position.z = 0.062;
  tick(model, state, in);
  in.grip = 1;
  EXPECT_TRUE(tick(model, state, in).holding) << "holds after the jaws opened and closed again";
}

// The force of a press beyond the limit stays at the limit and is reported as yielding.
TEST(RhombusTear, PressBeyondLimitYields) {
  const Model model = model_of({.chain = kStiff, .tear = 0.3});
  State state = make_state(model, 1);
  double before = 0;
  bool yielded = false;
  for (double depth = 0; depth < 0.05; depth += 1e-4) {
    const TouchForce f = tick(model, state, {.position = {0, 0, 0.065 - depth}, .radius = 0.005});
    EXPECT_GE(norm(f.force), before - 1e-9);
    EXPECT_EQ(f.yielding, norm(f.force) > 0.3 - 1e-9) << depth;
    before = norm(f.force), yielded |= f.yielding;
  }
  EXPECT_TRUE(yielded);
  EXPECT_NEAR(before, 0.3, 1e-9);
}

}  // namespace
}  // namespace turgor::rhombus

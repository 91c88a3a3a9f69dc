#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/rhombus/bodies.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {
namespace {

constexpr double kTick = 1e-3;
constexpr double kRadius = 0.005;

Model model_of(Surface surface, const Params& params = {}, std::vector<double> stiffness = {}) {
  return *build({std::move(surface.vertices), std::move(surface.triangles), std::move(stiffness)}, params);
}
Model slab_model(const Params& params = {}) { return model_of(test::slab(0.2, 40, 0.3), params); }
Model sphere_model(const Params& params = {}) { return model_of(test::sphere(0.06, 4), params); }

TouchInput ball(Vec3d position) { return {.position = position, .radius = kRadius}; }

/// One tick of one tool.
TouchForce tick(const Model& model, State& state, const TouchInput& input) {
  TouchForce force;
  solve_touches(model, state, {&input, 1}, kTick, {&force, 1});
  return force;
}

/// Largest jump of the force, scaled to 10 µm of motion, and the largest force.
struct Jumps {
  double largest = 0;  // per 10 µm [N]
  double strongest = 0;
  Vec3d before;
  bool first = true;

  void record(Vec3d force, double moved) {
    if (!first) largest = std::max(largest, norm(force - before) * std::min(1.0, 1e-5 / moved));
    strongest = std::max(strongest, norm(force));
    before = force, first = false;
  }
};

// A ball has the chain's force at its depth, along the normal.
TEST(RhombusTouch, BallForceIsChainForce) {
  const Model model = slab_model();
  State state = make_state(model, 1);
  for (const double depth : {0.001, 0.004, 0.012}) {
    const TouchForce force = tick(model, state, ball({0.003, 0.001, kRadius - depth}));
    EXPECT_NEAR(force.force.z, force_of_depth(model.chain, depth), 1e-9);
    EXPECT_NEAR(std::hypot(force.force.x, force.force.y), 0, 1e-9);
    EXPECT_NEAR(force.depth, depth, 1e-9);
    EXPECT_TRUE(force.touching);
  }
  EXPECT_EQ(tick(model, state, ball({0.003, 0.001, kRadius + 1e-6})).force, Vec3d{});
}

// The force is continuous at the first contact and at the release.
TEST(RhombusTouch, PressAndReleaseAreContinuous) {
  const Model model = sphere_model();
  State state = make_state(model, 1);
  const Vec3d direction = normalized(Vec3d{0.3, 0.5, 0.8});
  Jumps jumps;
  const double step = 1e-5;
  for (int i = -100; i <= 2000; i++) {  // 10 mm in and out
    const double depth = step * (i <= 1000 ? i : 2000 - i);
    jumps.record(tick(model, state, ball(direction * (0.06 + kRadius - depth))).force, step);
  }
  const double stiffest = 1 / depth_of_force(model.chain, jumps.strongest).compliance;
  EXPECT_LT(jumps.largest, 1.2 * std::max(stiffest, 1 / depth_of_force(model.chain, 0).compliance) * step);
  std::printf("press and release: largest jump per 10 um %.2e N of %.3f N\n", jumps.largest, jumps.strongest);
  EXPECT_EQ(jumps.before, Vec3d{});
}

// The force is continuous while a ball slides across vertices.
TEST(RhombusTouch, SlidingAcrossVerticesIsContinuous) {
  const double step = 1e-5;
  for (const double depth : {0.002, 0.008}) {
    const Model model = sphere_model();
    State state = make_state(model, 1);
    Jumps jumps;
    double least = 1;
    for (int i = 0; i < 8000; i++) {  // along a great circle that is no symmetry of the mesh
      const double a = i * step / 0.06;
      const Vec3d u = normalized(Vec3d{0.3, 0.5, 0.8}), w = normalized(cross(u, Vec3d{0.11, 1, -0.07}));
      const Vec3d direction = u * std::cos(a) + w * std::sin(a);
      const TouchForce force = tick(model, state, ball(direction * (0.06 + kRadius - depth)));
      jumps.record(force.force, step);
      least = std::min(least, norm(force.force));
    }
    std::printf("sliding at %.0f mm: largest jump per 10 um %.2e N of %.4f to %.4f N\n", depth * 1e3,
                jumps.largest, least, jumps.strongest);
    EXPECT_GT(least, 0);
    EXPECT_LT(jumps.largest,
              2e-3 * jumps.strongest);  // rotation of the normal alone gives 10 µm / 60 mm = 1.7e-4
    EXPECT_LT(jumps.strongest / least, 1.1) << "independent of the triangles";
  }
}

// A press and release returns exactly to the state at rest.
TEST(RhombusTouch, ReleaseReturnsExactlyToRest) {
  const Model model = slab_model({.bulge = 1});
  State state = make_state(model, 1);
  const Exec exec(1);
  const std::uint64_t rest = state_hash(state);
  for (const double depth : {0.001, 0.01, 0.004}) {
    tick(model, state, ball({0, 0, kRadius - depth}));
    step(exec, model, state);
    EXPECT_NE(state_hash(state), rest);
  }
  tick(model, state, ball({0, 0, kRadius + 0.001}));
  EXPECT_EQ(step(exec, model, state).largest_displacement, 0);
  EXPECT_EQ(state_hash(state), rest);
  EXPECT_EQ(energy(model, state), 0);
}

// The work of the tool equals the stored energy.
TEST(RhombusTouch, WorkEqualsStoredEnergy) {
  const Model model = slab_model();
  State state = make_state(model, 1);
  double work = 0;
  TouchForce before;
  const double ds = 1e-5;
  for (int i = 1; i <= 1200; i++) {
    const TouchForce force = tick(model, state, ball({0, 0, kRadius - i * ds}));
    work += 0.5 * (force.force.z + before.force.z) * ds;
    before = force;
  }
  EXPECT_NEAR(energy(model, state) / work, 1, 1e-4);
}

// A closed path over varying stiffness has nearly no net work.
TEST(RhombusTouch, ClosedPathHasNoWork) {
  Surface surface = test::slab(0.2, 40, 0.3);
  std::vector<double> stiffness;
  for (const Vec3d x : surface.vertices) stiffness.push_back(1 + 4 * std::exp(-dot(x, x) / (0.02 * 0.02)));
  const Model model = model_of(std::move(surface), {}, stiffness);
  State state = make_state(model, 1);
  // Press at a soft position, slide to a stiff one, retract, and return through the air.
  const Vec3d corners[] = {{0.05, 0.003, kRadius},
                           {0.05, 0.003, kRadius - 0.01},
                           {0.0, 0.003, kRadius - 0.01},
                           {0.0, 0.003, kRadius}};
  double work = 0, largest = 0;
  Vec3d last = tick(model, state, ball(corners[0])).force;
  for (int leg = 0; leg < 3; leg++)
    for (int i = 1; i <= 5000; i++) {
      const Vec3d d = (corners[leg + 1] - corners[leg]) / 5000;
      const Vec3d force = tick(model, state, ball(corners[leg] + d * i)).force;
      work -= 0.5 * dot(force + last, d);
      largest = std::max(largest, std::abs(work));
      last = force;
    }
  std::printf("closed path over uneven stiffness: %.3f %% of the work remains\n", 100 * work / largest);
  EXPECT_LT(std::abs(work), 0.05 * largest);  // 5 mm triangles under a bump of 20 mm
}

// The stiffness of the surface scales the force.
TEST(RhombusTouch, SurfaceStiffnessScalesForce) {
  Surface surface = test::slab(0.2, 40, 0.3);
  std::vector<double> stiffness(surface.vertices.size(), 3);
  const Model stiff = model_of(std::move(surface), {}, stiffness), plain = slab_model();
  State a = make_state(stiff, 1), b = make_state(plain, 1);
  const TouchInput input = ball({0.01, 0.02, kRadius - 0.007});
  EXPECT_NEAR(tick(stiff, a, input).force.z / tick(plain, b, input).force.z, 3, 1e-9);
}

// Two tools at the same position share the force of one.
TEST(RhombusTouch, CoincidentToolsShareForce) {
  const Model model = slab_model();
  State one = make_state(model, 1), two = make_state(model, 2);
  const TouchInput input = ball({0, 0, kRadius - 0.004});
  const TouchForce alone = tick(model, one, input);
  for (const double separation : {1e-5, 1e-3}) {
    TouchInput inputs[2] = {input, input};
    inputs[1].position.x += separation;
    TouchForce forces[2];
    solve_touches(model, two, inputs, kTick, forces);
    EXPECT_NEAR(forces[0].force.z, forces[1].force.z, 1e-6 * alone.force.z);
    EXPECT_NEAR(forces[0].force.z + forces[1].force.z, alone.force.z,
                (1e-3 + 50 * separation) * alone.force.z)
        << separation;
  }
}

// The surface below several tools has the depth of each of them.
TEST(RhombusTouch, SeveralToolsReachTheirDepths) {
  const Model model = slab_model();
  State state = make_state(model, 3);
  const double depth[3] = {0.006, 0.004, 0.005};
  const Vec3d position[3] = {{0, 0, 0}, {0.012, 0.002, 0}, {-0.004, 0.011, 0}};
  TouchInput inputs[3];
  for (int k = 0; k < 3; k++) inputs[k] = ball(position[k] + Vec3d{0, 0, kRadius - depth[k]});
  TouchForce forces[3];
  solve_touches(model, state, inputs, kTick, forces);
  step(Exec(1), model, state);
  for (int k = 0; k < 3; k++) {
    // The vertex nearest to the tool is some millimeters away, where the dent is slightly shallower.
    double nearest = 1;
    Vec3d move;
    for (std::size_t v = 0; v < model.surface.vertices.size(); v++)
      if (const double d = norm(model.surface.vertices[v] - position[k]); d < nearest)
        nearest = d, move = state.displacement[v];
    EXPECT_NEAR(-move.z, depth[k], 0.25 * depth[k]) << k;
  }
}

// A tool in a deeper dent of another tool has no force and is never pulled.
TEST(RhombusTouch, ToolInDeeperDentHasNoForce) {
  const Model model = slab_model();
  State state = make_state(model, 2);
  Jumps jumps;
  for (int i = 0; i <= 3000; i++) {  // the second tool presses beside the deep dent of the first one
    TouchInput inputs[2] = {ball({0, 0, kRadius - 0.012}), ball({0.006, 0, kRadius - i * 5e-6})};
    TouchForce forces[2];
    solve_touches(model, state, inputs, kTick, forces);
    EXPECT_GE(forces[1].force.z, 0);
    jumps.record(forces[1].force, 5e-6);
    if (i == 200) {
      EXPECT_EQ(forces[1].force, Vec3d{}) << "1 mm deep, where the other tool pressed several";
    }
  }
  EXPECT_GT(jumps.strongest, 0);
  EXPECT_LT(jumps.largest, 0.02 * jumps.strongest);
}

// A fast press on viscous tissue is stiffer, and its force relaxes exponentially.
TEST(RhombusTouch, ViscousForceRelaxes) {
  const Model elastic = slab_model(), viscous = slab_model({.viscosity = one_pair(1.5, 0.2)});
  State a = make_state(elastic, 1), b = make_state(viscous, 1);
  const TouchInput input = ball({0, 0, kRadius - 0.005});
  const double rest = tick(elastic, a, input).force.z, fast = tick(viscous, b, input).force.z;
  EXPECT_NEAR(fast / rest, 2.5, 0.01);
  double at = 0;
  for (int i = 0; i < 200; i++) at = tick(viscous, b, input).force.z;
  EXPECT_NEAR(at / rest, 1 + 1.5 * std::exp(-1.0), 0.02) << "after one relaxation time";
  for (int i = 0; i < 4000; i++) at = tick(viscous, b, input).force.z;
  EXPECT_NEAR(at / rest, 1, 1e-6);
}

// Three pairs follow the convolution of the elastic force's history within 1 %, after ramps of three
// durations.
TEST(RhombusTouch, ThreePairsMatchRampAndHold) {
  const Prony law{{{{0.8, 0.1}, {0.5, 1}, {0.3, 10}}}};
  const Model elastic = slab_model(), viscous = slab_model({.viscosity = law});
  for (const double ramp : {0.05, 0.5, 5.0}) {
    State a = make_state(elastic, 1), b = make_state(viscous, 1);
    const int ticks = int(std::lround(ramp * 1000));
    std::vector<double> rises;  // of the elastic force in every tick [N]
    double before = 0, peak = 0;
    for (int i = 1; i <= 5 * ticks; i++) {
      const TouchInput input = ball({0, 0, kRadius - 0.005 * std::min(1.0, double(i) / ticks)});
      const double rest = tick(elastic, a, input).force.z, now = tick(viscous, b, input).force.z;
      rises.push_back(rest - before), before = rest;
      if (i % ticks != 0) continue;
      // σ(t) = Σ rise (1 + Σ pᵢ exp(−(t − s)/τᵢ)), each rise at the middle of its tick
      double exact = 0;
      for (std::size_t n = 0; n < rises.size(); n++) {
        double factor = 1;
        for (const PronyPair& pair : law.pairs)
          factor += pair.ratio * std::exp(-1e-3 * (i - double(n) - 0.5) / pair.time);
        exact += factor * rises[n];
      }
      peak = std::max(peak, exact);
      EXPECT_NEAR(now, exact, 0.01 * peak) << ramp << " s, tick " << i;
    }
    EXPECT_GT(peak, 1.2 * before) << "the peak relaxes";
  }
}

// Viscous tissue dissipates energy and recovers its shape.
TEST(RhombusTouch, ViscousTissueRecoversAndDissipates) {
  const Model model = slab_model({.viscosity = one_pair(1.5, 0.2)});
  State state = make_state(model, 1);
  const Exec exec(1);
  double work = 0, remaining = 0;
  Vec3d last;
  double z = kRadius;
  for (int i = 1; i <= 300; i++) {  // 6 mm in at 40 mm/s, and out
    const double next = kRadius - 4e-5 * (i <= 150 ? i : 300 - i);
    const Vec3d force = tick(model, state, ball({0, 0, next})).force;
    EXPECT_GE(force.z, 0) << "no adhesion";
    work -= 0.5 * (force.z + last.z) * (next - z);
    z = next, last = force;
  }
  EXPECT_GT(work, 0);
  remaining = step(exec, model, state).largest_displacement;
  EXPECT_GT(remaining, 1e-4) << "the dent remains";
  for (int i = 0; i < 8000; i++) EXPECT_EQ(tick(model, state, ball({0, 0, 0.05})).force, Vec3d{});
  EXPECT_EQ(step(exec, model, state).largest_displacement, 0);
}

// Random paths of three tools stay finite for 100 000 ticks.
TEST(RhombusTouch, RandomPathsStayFinite) {
  Params params{.bulge = 0.7, .viscosity = one_pair(0.8, 0.05)};
  const Model model = sphere_model(params);
  State state = make_state(model, 3);
  const Exec exec(1);
  std::mt19937 random(3);
  std::normal_distribution<double> shake(0, 0.0015);
  Vec3d position[3] = {{0.06, 0, 0}, {0, 0.06, 0}, {0, 0, -0.06}};
  double grip[3] = {}, strongest = 0;
  for (int i = 0; i < 100000; i++) {
    TouchInput inputs[3];
    for (int k = 0; k < 3; k++) {
      Vec3d& x = position[k];
      x += Vec3d{shake(random), shake(random), shake(random)};
      x = normalized(x) * std::clamp(norm(x), 0.03, 0.08);
      if (random() % 500 == 0) grip[k] = grip[k] > 0 ? 0 : 0.5 + 0.5 * double(random() % 2);
      inputs[k] = ball(x);
      inputs[k].grip = grip[k], inputs[k].opening = 0.006 * (1 - grip[k]);
      if (random() % 1000 == 0) inputs[k].position.x = std::nan("");
    }
    TouchForce forces[3];
    solve_touches(model, state, inputs, kTick, forces);
    for (const TouchForce& f : forces) {
      ASSERT_TRUE(std::isfinite(norm(f.force))) << i;
      strongest = std::max(strongest, norm(f.force));
    }
    if (i % 500 != 0) continue;
    ASSERT_TRUE(step(exec, model, state).finite) << i;
  }
  EXPECT_GT(strongest, 0);
}

// A pose that is not finite gives no force and does not affect later ticks.
TEST(RhombusTouch, NonFiniteInputHasNoForce) {
  const Model model = slab_model();
  State state = make_state(model, 1);
  const TouchInput good = ball({0, 0, kRadius - 0.004});
  const TouchForce before = tick(model, state, good);
  TouchInput bad = good;
  bad.position.y = std::numeric_limits<double>::infinity();
  const TouchForce force = tick(model, state, bad);
  EXPECT_TRUE(force.invalid_input);
  EXPECT_EQ(force.force, Vec3d{});
  EXPECT_NEAR(tick(model, state, good).force.z, before.force.z, 1e-12);
}

}  // namespace
}  // namespace turgor::rhombus

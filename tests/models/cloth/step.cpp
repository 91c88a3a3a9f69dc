#include <algorithm>
#include <array>

#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {
namespace {

/// A square held at its first row, hanging down along y.
struct Hanging {
  Model model;
  State state;
};
Hanging hanging(const Params& params, int n = 21, double spacing = 0.02) {
  Hanging h{.model = must_build(flat_sheet(n, spacing), params), .state = {}};
  h.state = make_state(h.model);
  for (int i = 0; i < n; i++) EXPECT_TRUE(hold(h.model, h.state, i));
  return h;
}

// A hanging spring reaches its static length.
TEST(ClothStep, HangingSpringReachesStaticLength) {
  // Two triangles: the upper corners are held, and each lower one hangs with m g on springs along y.
  Params params{
      .fabric = {.law = Law::kSprings, .density = 1, .warp = 500, .weft = 200, .shear = 0, .bend = 0}};
  params.collision.self = false;
  params.solver.sweeps = 1;
  params.damping.motion = 4;
  const Model model = must_build(flat_sheet(2, 0.1), params);
  State state = make_state(model);
  for (const int v : {0, 1}) ASSERT_TRUE(hold(model, state, v));
  Inputs inputs = in_vacuum(0);
  inputs.gravity = {0, 9.81, 0};
  for (int frame = 0; frame < 1200; frame++) step(Exec(1), model, state, inputs, kFrame);
  double force = 0;  // of both lower corners
  for (const int v : {2, 3}) force += model.mass[std::size_t(v)] * 9.81;
  double pull = 0;  // of the vertical edges, E A/L² each with half of the square's area
  for (const int v : {2, 3}) pull += 200 * 0.5 * (state.x.y[std::size_t(v)] - 0.1);
  EXPECT_NEAR(pull / force, 1, 1e-3);
}

// The shape at rest depends neither on the solver nor on the number of sweeps.
TEST(ClothStep, RestShapeIndependentOfSweeps) {
  std::vector<double> ends;
  for (const auto& [method, sweeps] :
       {std::pair(Method::kJacobi, 1), std::pair(Method::kJacobi, 2), std::pair(Method::kChebyshev, 8),
        std::pair(Method::kConjugateGradients, 30)}) {
    Params params{.fabric = {.warp = 20, .weft = 20, .shear = 5, .bend = 1}};
    params.solver = {.method = method, .sweeps = sweeps};
    params.damping.motion = 3;
    params.collision.self = false;
    Hanging h = hanging(params, 11);
    Inputs inputs = in_vacuum(0);
    inputs.gravity = {0, 9.81, 0};
    for (int frame = 0; frame < 1200; frame++) step(Exec(1), h.model, h.state, inputs, kFrame);
    ends.push_back(double(h.state.x.y[115]));
  }
  EXPECT_GT(ends[0], 0.201);  // it is stretched
  for (const double end : ends) EXPECT_NEAR((end - 0.2) / (ends.back() - 0.2), 1, 0.01);
}

// Momentum is conserved without external forces.
TEST(ClothStep, ConservesMomentum) {
  Params params;
  params.damping.motion = 0;
  params.solver = {.method = Method::kConjugateGradients, .sweeps = 200, .tolerance = 0};
  params.fabric.warp = params.fabric.weft = 100;
  const Model model = must_build(flat_sheet(15), params);
  State state = make_state(model);
  shake(model, state.x, 0.002);
  shake(model, state.v, 0.5, 2);
  const Vec3d before = momentum(model, state);
  const Exec exec(2);
  for (int frame = 0; frame < 60; frame++) step(exec, model, state, in_vacuum(0), kFrame);
  EXPECT_LT(norm(momentum(model, state) - before), 2e-4 * model.total_mass * 0.5);
}

/// Largest growth of the energy in a frame, relative to a scale [J].
double energy_growth(const Model& model, State& state, const Inputs& inputs, int frames, double scale) {
  const auto total = [&] {
    const Energy e = energy(model, state, inputs.gravity);
    return e.elastic + e.kinetic + e.potential;
  };
  const double first = total();
  double last = first, growth = 0;
  for (int frame = 0; frame < frames; frame++) {
    step(Exec(1), model, state, inputs, kFrame);
    const double now = total();
    growth = std::max(growth, now - last);
    last = now;
  }
  EXPECT_LT(last, first);
  return growth / scale;
}

// The energy does not grow without wind.
TEST(ClothStep, EnergyDoesNotGrowWithoutWind) {
  for (const Method method : {Method::kJacobi, Method::kChebyshev})
    for (const double size : {0.0003, 0.001, 0.003}) {
      Params params;
      params.solver = {.method = method, .sweeps = 200};
      params.damping = {0, 0};
      params.collision.self = false;
      const Model model = must_build(flat_sheet(20), params);
      State state = make_state(model);
      ASSERT_TRUE(hold(model, state, 0));
      shake(model, state.x, size);
      shake(model, state.v, 0.3, 2);
      const Energy e = energy(model, state, {});
      EXPECT_LT(energy_growth(model, state, in_vacuum(0), 200, e.elastic + e.kinetic), 5e-5) << size;
    }
}

// A swinging sheet gains little energy in any frame and loses energy overall.
TEST(ClothStep, SwingingSheetLosesEnergy) {
  Params params;
  params.damping = {0, 0};
  params.collision.thickness = 0.015;
  Hanging h = hanging(params);
  // Flat springs have no stiffness across the sheet, so the first frames overshoot: see docs/models/cloth.md.
  for (int frame = 0; frame < 10; frame++) step(Exec(1), h.model, h.state, in_vacuum(), kFrame);
  const double fall = h.model.total_mass * 9.81 * 0.2;  // of its center
  EXPECT_LT(energy_growth(h.model, h.state, in_vacuum(), 300, fall), 0.02);
}

/// Largest stretch of a shaken hanging sheet after 150 frames in gusts [1].
double stretch_in_gusts(double h, int sweeps, unsigned seed) {
  Params params{.fabric = {.warp = 5000, .weft = 5000, .shear = 500}};
  params.solver.sweeps = sweeps;
  Hanging cloth = hanging(params, 13);
  shake(cloth.model, cloth.state.x, 0.004, seed);
  Inputs inputs{.gravity = {0, 0, -9.81}};
  inputs.air.velocity = {0, 3, 1};
  inputs.air.gusts = 0.3;
  StepReport report;
  for (int frame = 0; frame < 150; frame++) {
    report = step(Exec(1), cloth.model, cloth.state, inputs, h);
    EXPECT_TRUE(report.finite) << h << " s, " << sweeps << " sweeps, seed " << seed;
  }
  EXPECT_LT(report.largest_speed, 5) << h << " s, " << sweeps << " sweeps, seed " << seed;
  return largest_stretch(cloth.model, cloth.state);
}

// Time steps from 1 to 33 ms are stable in gusts.
TEST(ClothStep, StableFrom1To33Milliseconds) {
  for (const double h : {0.001, 0.004, kFrame, 0.033})
    for (const int sweeps : {1, 8}) {
      if (sweeps == 1 && h > kFrame) continue;  // tested below
      EXPECT_LT(stretch_in_gusts(h, sweeps, 1), 2) << h << " s, " << sweeps << " sweeps";
    }
  // One sweep in a frame as long as that has a large residual, so the stretch depends on the initial shake
  // and on rounding. Of 60 seeds, half are below 1.8, nine in ten below 2.7, and one is 5.5.
  std::array<double, 5> stretch{};
  for (unsigned seed = 1; seed <= stretch.size(); seed++)
    stretch[seed - 1] = stretch_in_gusts(0.033, 1, seed);
  std::sort(stretch.begin(), stretch.end());
  EXPECT_LT(stretch[2], 2.5) << "the median";
}

// A hold moves its vertex exactly to the goal; a release ends it.
TEST(ClothStep, HoldReachesGoalExactly) {
  Hanging h = hanging({});
  const Vec3 goal{0.01f, 0.02f, 0.05f};
  ASSERT_TRUE(move_hold(h.model, h.state, 3, goal));
  step(Exec(1), h.model, h.state, in_vacuum(), kFrame);
  EXPECT_EQ(h.state.x[std::size_t(h.model.model_vertex[3])], goal);
  ASSERT_TRUE(release(h.model, h.state, 3));
  step(Exec(1), h.model, h.state, in_vacuum(), kFrame);
  EXPECT_NE(h.state.x[std::size_t(h.model.model_vertex[3])], goal);
}

// The strain limit bounds the stretch of springs.
TEST(ClothStep, StrainLimitBoundsStretch) {
  double stretch[2];
  for (const int limited : {0, 1}) {
    Params params{.fabric = {.density = 1, .warp = 25, .weft = 25, .shear = 5, .bend = 1}};
    params.solver.strain_limit = limited ? 0.1 : 0;
    params.collision.self = false;
    Hanging h = hanging(params);
    Inputs inputs = in_vacuum(0);
    inputs.gravity = {0, 9.81, 0};
    for (int frame = 0; frame < 400; frame++) step(Exec(1), h.model, h.state, inputs, kFrame);
    stretch[limited] = largest_stretch(h.model, h.state);
  }
  EXPECT_GT(stretch[0], 1.15);
  EXPECT_LT(stretch[1], 1.15);
}

// One, two and eight threads give the same bits.
TEST(ClothStep, EqualBitsOnAnyThreads) {
  std::uint64_t expected = 0;
  for (const Method method : {Method::kChebyshev, Method::kConjugateGradients})
    for (const int threads : {1, 2, 8}) {
      Params params;
      params.collision.thickness =
          method == Method::kChebyshev ? 0.006 : 0.0096;  // with and without large triangles
      params.solver.method = method;
      const Model model = must_build(flat_sheet(24), params);
      State state = make_state(model);
      ASSERT_TRUE(hold(model, state, 0));
      shake(model, state.x, 0.01);
      Inputs inputs{.gravity = {0, 0, -9.81}};
      inputs.air.velocity = {4, 1, 0};
      inputs.air.gusts = 0.5;
      const Exec exec(threads);
      int contacts = 0;
      for (int frame = 0; frame < 12; frame++) contacts += step(exec, model, state, inputs, kFrame).contacts;
      EXPECT_GT(contacts, 100);
      if (threads == 1) expected = state_hash(model, state);
      EXPECT_EQ(state_hash(model, state), expected) << threads;
    }
}

/// Amplitude of a hanging strip of half a meter after five seconds relative to the first one, and its period
/// relative to that of a rope.
struct Swing {
  double amplitude = 0, period = 0;
};
Swing swing(Integrator integrator, int rate, int cells) {
  Params params{
      .fabric = {.law = Law::kSheet},
      .solver = {.integrator = integrator, .method = Method::kTwoLevel, .sweeps = 200, .tolerance = 1e-3}};
  params.damping = {0, 0};
  params.collision.self = false;
  params.fabric.rigidity_warp = params.fabric.rigidity_weft = 1e-8;
  const double length = 0.5, start = 0.01;
  const TriMesh mesh =
      make_sheet({.side = {length, 0, 0}, .up = {0, length / cells, 0}, .columns = cells, .rows = 1});
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  Inputs inputs = in_vacuum(0);
  inputs.gravity = {9.81, 0, 0};
  for (const int v : {0, cells + 1}) EXPECT_TRUE(hold(model, state, v));
  for (std::size_t v = 0; v < std::size_t(model.count); v++)
    state.x.z[v] =
        Real(start * std::cyl_bessel_j(
                         0, 2.404825557695773 * std::sqrt(std::max(0.0, 1 - double(state.x.x[v]) / length))));
  const auto tip = std::size_t(model.model_vertex[std::size_t(cells)]);
  double before = start, most = 0, first = 0, last = 0;
  int crossings = 0;
  for (int n = 1; n <= 5 * rate; n++) {
    step(Exec(1), model, state, inputs, 1.0 / rate);
    const double now = double(state.x.z[tip]);
    if (n > 4 * rate) most = std::max(most, std::abs(now));
    if (now * before < 0) {
      const double time = (n - now / (now - before)) / rate;
      (crossings++ == 0 ? first : last) = time;
    }
    before = now;
  }
  const double expected = 4 * 3.14159265358979 / 2.404825557695773 * std::sqrt(length / 9.81);
  return {most / start, crossings > 1 ? 2 * (last - first) / (crossings - 1) / expected : 0};
}

// BDF2 keeps the amplitude of a swing that backward Euler damps.
TEST(ClothStep, Bdf2KeepsSwingThatEulerDamps) {
  double euler[2], bdf2[2];
  for (const int fast : {0, 1}) {
    const int rate = fast ? 240 : 60;
    euler[fast] = swing(Integrator::kEuler, rate, 25).amplitude;
    bdf2[fast] = swing(Integrator::kBdf2, rate, 25).amplitude;
  }
  EXPECT_LT(euler[0], 0.6);
  EXPECT_LT(euler[1], 0.9);
  EXPECT_NEAR(bdf2[0], 1, 0.08);
  EXPECT_NEAR(bdf2[1], 1, 0.03);
}

// A strip swings with the period of a rope for any cell size, and with the same amplitude.
TEST(ClothStep, StripSwingsAsRope) {
  const Swing finest = swing(Integrator::kBdf2, 120, 100);
  for (const int cells : {25, 50, 100}) {
    const Swing found = swing(Integrator::kBdf2, 120, cells);
    EXPECT_NEAR(found.period, 1, 0.02) << cells;
    EXPECT_NEAR(found.amplitude / finest.amplitude, 1, 0.02) << cells;
  }
}

// A step that is not finite is undone; the next one is finite.
TEST(ClothStep, NonFiniteStepIsUndone) {
  Hanging h = hanging({});
  const Vec3 before = h.state.x[200];
  Inputs inputs = in_vacuum();
  inputs.gravity.z = INFINITY;
  EXPECT_FALSE(step(Exec(1), h.model, h.state, inputs, kFrame).finite);
  EXPECT_EQ(h.state.x[200], before);
  EXPECT_TRUE(step(Exec(1), h.model, h.state, in_vacuum(), kFrame).finite);
}

// Random steps stay finite.
TEST(ClothStep, RandomStepsStayFinite) {
  Params params;
  params.collision.thickness = 0.0096;
  const Model model = must_build(flat_sheet(9), params);
  State state = make_state(model);
  const Exec exec(1);
  RandomNumbers next{7};
  constexpr int kSteps = 100000;
  state.ccd.steps_until_check = kSteps;  // as if it crossed itself, which skips CCD: ClothCcd tests the rest
  for (int n = 0; n < kSteps; n++) ASSERT_TRUE(storm_step(exec, model, state, next, true).finite) << n;
}

// The force of holds is the weight of the sheet plus the inertia of moved vertices.
TEST(ClothStep, HoldForceHasWeightAndInertia) {
  Params params{.solver = {.sweeps = 64}};
  params.damping.motion = 2;
  const Model model = must_build(flat_sheet(20), params);
  State state = make_state(model);
  for (int v = 0; v < 20; v++) ASSERT_TRUE(hold(model, state, v));
  const Inputs inputs = in_vacuum();
  const auto total_hold_force = [&](Vec3d change) {
    Vec3d sum;
    for (int v = 0; v < 20; v++) sum += hold_force(model, state, v, inputs.gravity, change, kFrame);
    return sum;
  };
  for (int n = 0; n < 600; n++) step(Exec(1), model, state, inputs, kFrame);
  const double weight = model.total_mass * 9.81;
  EXPECT_NEAR(total_hold_force({}).z, weight, 0.01 * weight) << "N, at rest";
  EXPECT_LT(std::hypot(total_hold_force({}).x, total_hold_force({}).y), 0.01 * weight);
  // A vertex that gains 0.1 m/s in a frame adds the inertia of its own mass.
  EXPECT_NEAR(total_hold_force({0, 0, 0.1}).z - total_hold_force({}).z,
              0.1 / kFrame * model.total_mass * 19.0 / 38 / 19, 1e-4 * weight);
}

// A sheet needs less than 400 bytes per vertex, and 500 with the two-level solver.
TEST(ClothStep, MemoryPerVertexIsBounded) {
  for (const auto& [method, most] : {std::pair(Method::kChebyshev, 400), std::pair(Method::kTwoLevel, 500)}) {
    const Model model = must_build(
        flat_sheet(200),
        {.fabric = {.law = Law::kSheet}, .solver = {.method = method}, .collision = {.thickness = 0.0096}});
    State state = make_state(model);
    step(Exec(1), model, state, in_vacuum(), kFrame);
    EXPECT_LT(double(memory_bytes(model, state)) / model.count, most);
  }
}

}  // namespace
}  // namespace turgor::cloth

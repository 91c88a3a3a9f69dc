// Springs on points embedded in whole and cut cells.
#include "turgor/models/lattice/mechanics/point_springs.hpp"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/cutting/embed_point.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kSerial(1);
constexpr double kFrame = 1.0 / 60;

EmbeddedPoint embedded(const Model& model, const State& state, Vec3d at) {
  const auto fragments = fragments_of(model, state.cuts);
  return embed_point(model, state.cuts, *fragments, at).value();
}
PointSprings springs_of(std::vector<PointSpring> all) {
  PointSprings springs{.all = std::move(all)};
  make_terms(springs);
  return springs;
}

/// A block without fixed nodes and without skin.
Model free_block(int sweeps) {
  Params params = solid_params(sweeps, 8, 0);
  params.skin.enabled = false;
  return block_model({.size = {9, 7, 7}, .skin_on_top = false}, params);
}
double mass_of(const Model& model) {
  double mass = 0;
  for (const Real w : model.anatomy.inverse_mass)
    if (w > 0) mass += 1 / double(w);
  return mass;
}
/// Σ m v and Σ m x × v about the origin.
struct Momenta {
  Vec3d linear, angular;
};
Momenta momenta(const Model& model, const State& state) {
  Momenta sum;
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++) {
    if (!(model.anatomy.inverse_mass[s] > 0)) continue;
    const Vec3d p = Vec3d(state.motion.v[s]) / double(model.anatomy.inverse_mass[s]);
    const Int3 node = slot_node(model.anatomy.lattice, int(s));
    sum.linear += p;
    sum.angular += cross(Vec3d(position(model, state.motion, node)), p);
  }
  return sum;
}

// Trilinear weights reproduce linear fields, also beyond the whole cell next to the skin.
TEST(PointSprings, WeightsReproduceLinearField) {
  const Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  const Lattice& l = wounded.model.anatomy.lattice;
  for (const Vec3d at : {Vec3d{0.0331, 0.0512, 0.0133}, {0.02, 0.0234, 0.024}, {0.05, 0.06, 0.0245}}) {
    const EmbeddedPoint point = embedded(wounded.model, wounded.state, at);
    Vec3d sum;
    double weight = 0;
    for (std::size_t c = 0; c < 8; c++) {
      ASSERT_LT(point.corner[c], slot_count(l)) << "away from the wound";
      sum += Vec3d(rest_position(l, slot_node(l, point.corner[c]))) * double(point.weight[c]);
      weight += double(point.weight[c]);
    }
    EXPECT_LT(norm(sum - at), 1e-7) << "m";
    EXPECT_NEAR(weight, 1, 1e-6);
  }
  const auto fragments = fragments_of(wounded.model, wounded.state.cuts);
  EXPECT_FALSE(embed_point(wounded.model, wounded.state.cuts, *fragments, {0.05, 0.05, 0.0275}));
  EXPECT_FALSE(embed_point(wounded.model, wounded.state.cuts, *fragments, {-0.05, 0.05, 0.01}));
}

// A body on one spring hangs m g / k below the target.
TEST(PointSprings, HangingBodyStretchesSpring) {
  const Model model = free_block(6);
  State state = make_state(model);
  constexpr Real kStiffness = 30;
  const Vec3 target{1e-3f, -2e-3f, 3e-3f};
  PointSprings springs = springs_of({{.at = embedded(model, state, {0.016, 0.012, 0.012}),
                                      .target = target,
                                      .stiffness = axial_stiffness({0, 0, 1}, kStiffness, 2 * kStiffness)}});
  const Inputs inputs{.gravity = {0, 0, -9.81}, .springs = &springs};
  for (int n = 0; n < 200; n++) ASSERT_TRUE(step(kSerial, model, state, inputs, kFrame).finite);
  const double drop = mass_of(model) * 9.81 / double(kStiffness);
  const Vec3d u(displacement(springs.all[0].at, state.motion));
  std::printf("%.4f mm below, expected %.4f mm\n", 1e3 * (double(target.z) - u.z), 1e3 * drop);
  EXPECT_NEAR(double(target.z) - u.z, drop, 1e-3 * drop) << "m";
  EXPECT_NEAR(u.x, double(target.x), 1e-3 * drop) << "m";
  EXPECT_NEAR(u.y, double(target.y), 1e-3 * drop) << "m";
}

// Opposite forces on two points give a free body no momentum.
TEST(PointSprings, OppositeForcesKeepMomentum) {
  const Model model = free_block(20);
  State state = make_state(model);
  const Vec3d a{0.0081, 0.0093, 0.0102}, b{0.0247, 0.0152, 0.0137};
  const Vec3 pull = Vec3(normalized(b - a)) * Real(0.02);
  PointSprings springs = springs_of(
      {{.at = embedded(model, state, a), .force = pull}, {.at = embedded(model, state, b), .force = -pull}});
  double moving = 0;
  for (int n = 0; n < 8; n++) {
    ASSERT_TRUE(step(kSerial, model, state, {.springs = &springs}, kFrame).finite);
    moving = std::max(moving, double(state.motion.fastest));
  }
  const Momenta sum = momenta(model, state);
  const double scale = mass_of(model) * moving;
  EXPECT_GT(moving, 1e-4);
  EXPECT_LT(norm(sum.linear), 2e-3 * scale);
  EXPECT_LT(norm(sum.angular), 2e-3 * scale * 0.03);
}

/// Forces on the lips of a wound that open it, or close it if `sign` is −1, and springs that hold them.
PointSprings across_wound(const Wounded& wounded, Real sign, Real stiffness) {
  const std::size_t n = wounded.path.points.size() / 2;
  const Vec3d middle = wounded.path.points[n] + wounded.path.inward[n] * 0.003,
              aside = across_at(wounded.path, n) * 3e-4;
  const Vec3 force = Vec3(across_at(wounded.path, n)) * (sign * Real(0.3));
  return springs_of({{.at = embedded(wounded.model, wounded.state, middle - aside),
                      .stiffness = isotropic_stiffness(stiffness),
                      .force = -force},
                     {.at = embedded(wounded.model, wounded.state, middle + aside),
                      .stiffness = isotropic_stiffness(stiffness),
                      .force = force}});
}

// Points on two sides of a blade belong to different fragments, and a pair of forces opens or closes the
// wound.
TEST(PointSprings, PointsOfCutCellFollowTheirSide) {
  double gape[3];
  for (int sign = -1; sign <= 1; sign++) {
    Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
    PointSprings springs = across_wound(wounded, Real(sign), 0);
    int different = 0;
    for (std::size_t c = 0; c < 8; c++)
      different += springs.all[0].at.corner[c] != springs.all[1].at.corner[c];
    EXPECT_EQ(different, 8);
    for (int n = 0; n < 15; n++)
      ASSERT_TRUE(step(kSerial, wounded.model, wounded.state, {.springs = &springs}, 2 * kFrame).finite);
    const Vec3 apart = displacement(springs.all[1].at, wounded.state.motion) -
                       displacement(springs.all[0].at, wounded.state.motion);
    gape[sign + 1] = dot(Vec3d(apart), across_at(wounded.path, wounded.path.points.size() / 2));
  }
  std::printf("gape %.2f, %.2f, %.2f mm\n", 1e3 * gape[0], 1e3 * gape[1], 1e3 * gape[2]);
  EXPECT_LT(gape[0], gape[1] - 2e-4) << "m";
  EXPECT_GT(gape[2], gape[1] + 2e-4) << "m";
}

// Sweeps never raise the energy of a step with springs, and converge to no residual.
TEST(PointSprings, SweepsDescendToMinimum) {
  for (const Ordering ordering : {Ordering::kSlabs, Ordering::kColors}) {
    Params params = solid_params(5, 4, 45);
    params.solver.ordering = ordering;
    Wounded wounded(0.3, 0.5, 20, params);
    PointSprings springs = across_wound(wounded, 1, 20);
    for (PointSpring& spring : springs.all) spring.stiffness = axial_stiffness({0, 1, 0}, 400, 30);
    const Inputs inputs{.springs = &springs};
    predict(kSerial, wounded.model, wounded.state, inputs, kFrame);
    const double first = measure_residual(kSerial, wounded.model, wounded.state, inputs, kFrame).rms;
    double before = step_energy(kSerial, wounded.model, wounded.state, inputs, kFrame);
    for (int sweep = 0; sweep < 40; sweep++) {
      sweep_vbd(kSerial, wounded.model, wounded.state, inputs, kFrame,
                sweep % 2 ? Order::kBackward : Order::kForward);
      const double after = step_energy(kSerial, wounded.model, wounded.state, inputs, kFrame);
      EXPECT_LE(after, before + 1e-6 * std::abs(before)) << "sweep " << sweep;
      before = after;
    }
    for (int sweep = 0; sweep < 150; sweep++)
      sweep_vbd(kSerial, wounded.model, wounded.state, inputs, kFrame,
                sweep % 2 ? Order::kBackward : Order::kForward);
    EXPECT_LT(measure_residual(kSerial, wounded.model, wounded.state, inputs, kFrame).rms, 2e-2 * first);
  }
}

/// Displacement of the end of a soft bar of 40 cells, with a spring at its end, after some steps [m].
double end_of_bar(bool coarse, int steps) {
  Params params = solid_params(4, 1, 0);
  params.skin.enabled = false, params.solver.coarse = coarse;
  const Model model = block_model(
      {.size = {41, 5, 5}, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.x == 0; }}, params);
  State state = make_state(model);
  PointSprings springs = springs_of({{.at = embedded(model, state, {0.158, 0.008, 0.008}),
                                      .target = {2e-3f, 0, 0},
                                      .stiffness = axial_stiffness({1, 0, 0}, 100, 0)}});
  for (int n = 0; n < steps; n++)
    EXPECT_TRUE(step(kSerial, model, state, {.springs = &springs}, 10 * kFrame).finite);
  return double(displacement(springs.all[0].at, state.motion).x);
}

// The coarse correction sees the springs: the bar reaches the same equilibrium with it, in fewer steps.
TEST(PointSprings, CoarseCorrectionCarriesSpring) {
  const double settled = end_of_bar(true, 60), plain = end_of_bar(false, 150);
  std::printf("%.4f mm with, %.4f mm without the correction\n", 1e3 * settled, 1e3 * plain);
  EXPECT_NEAR(settled, plain, 2e-3 * plain) << "m";
  EXPECT_LT(std::abs(end_of_bar(true, 8) - settled), 0.5 * std::abs(end_of_bar(false, 8) - settled)) << "m";
}

// A spring wakes the rows around it.
TEST(PointSprings, SpringWakesSleepingRows) {
  Params params = solid_params(5, 4, 0);
  params.skin.enabled = false, params.solver.sleep_speed = 1e-4;
  const Model model = block_model(
      {.size = {9, 25, 7}, .skin_on_top = false, .is_fixed = [](Int3 p) { return p.z == 0; }}, params);
  State state = make_state(model);
  StepReport report = step(kSerial, model, state, {}, kFrame);
  EXPECT_EQ(report.rows_asleep, report.rows);
  PointSprings springs =
      springs_of({{.at = embedded(model, state, {0.016, 0.048, 0.02}), .force = {0, 0, 0.05f}}});
  for (int n = 0; n < 30; n++) report = step(kSerial, model, state, {.springs = &springs}, kFrame);
  EXPECT_LT(report.rows_asleep, report.rows);
  EXPECT_GT(displacement(springs.all[0].at, state.motion).z, 1e-4f) << "m";
}

// The state does not depend on the number of threads.
TEST(PointSprings, SameBitsOnAnyThreads) {
  for (const Ordering ordering : {Ordering::kSlabs, Ordering::kColors}) {
    std::uint64_t hash[3];
    for (const int run : {0, 1, 2}) {
      Params params = solid_params(5, 4, 45);
      params.solver.ordering = ordering;
      Wounded wounded(0.3, 0.5, 20, params);
      PointSprings springs = across_wound(wounded, 1, 20);
      const Exec exec(run == 0 ? 1 : run == 1 ? 2 : 8);
      for (int n = 0; n < 5; n++) step(exec, wounded.model, wounded.state, {.springs = &springs}, kFrame);
      hash[run] = state_hash(wounded.model, wounded.state);
    }
    EXPECT_EQ(hash[0], hash[1]);
    EXPECT_EQ(hash[0], hash[2]);
  }
}

}  // namespace
}  // namespace turgor::lattice

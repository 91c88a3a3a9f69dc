// The step of the smooth part by the loops that a GPU runs: each of them by another formulation, and bodies
// that step on the other side of a bus, in a shuffled order, by what is known of where they come to rest.
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/models/host_side.hpp"
#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

using Side = HostSide<SeededRun<3>>;
const Exec kOne(1);
const SeededRun<3> kShuffled;
constexpr double kDt = 1.0 / 60;

/// A wound in disorder, on the other side.
struct There {
  Wounded wounded{0.3, 0.5, 20, solid_params(5, 4, 45)};
  Inputs inputs{.gravity = {1, 2, -9}};
  DeviceAllocator<Side> rooms;
  DeviceNodes<Side> nodes{rooms, wounded.model};
  DeviceVbd<Side> vbd{rooms, wounded.model};
  DeviceCoarse<Side> coarse{rooms, wounded.model};

  There() {
    const Model& model = wounded.model;
    State& state = wounded.state;
    scatter(model, state, 0.0005);
    predict(kOne, model, state, inputs, kDt);
    EXPECT_TRUE(prepare_coarse_space(model, state, inputs, kDt));
    nodes.u.upload(state.u), nodes.u_before.upload(state.u_before), nodes.v.upload(state.v);
    nodes.put_cuts(state), vbd.put_cuts(model, state);
    coarse.put(model, state);
  }
  VbdView body() const { return vbd.view(wounded.model, nodes, inputs, kDt); }
  CoarseView view() const { return coarse.view(wounded.model); }

  /// What the step's energy is when the unknowns have gone so far along a way.
  double energy_after(const std::vector<double>& way, Real part) {
    const CoarseView c = view();
    std::copy(way.begin(), way.end(), c.way);
    c.search->part = part;
    multiply_with<3>(kShuffled, c.to_corners, c.way, c.piece_sums, c.corners);
    kShuffled(std::size_t(c.stretch_count) * kAddedTogether,
              MoveFollower{c, body().body.nodes, body().parts.virtual_nodes});
    State moved = wounded.state;
    nodes.u.download(moved.u), vbd.shifts.room.download(moved.virtual_nodes);
    nodes.u.upload(wounded.state.u), vbd.shifts.put(wounded.state.virtual_nodes);
    return step_energy(kOne, wounded.model, moved, inputs, kDt);
  }
};

std::vector<double> any_numbers(std::size_t count, double most) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-most, most);
  std::vector<double> numbers(count);
  for (double& n : numbers) n = any(random);
  return numbers;
}

TEST(lattice_coarse_loops, what_unknowns_are_asked_for_is_the_slope_of_the_energy_along_them) {
  There there;
  const CoarseView c = there.view();
  find_wanted_with(kShuffled, there.body(), c);
  const std::vector<double> wanted(c.wanted, c.wanted + c.numbers());
  ASSERT_GT(there.wounded.state.virtual_nodes.size(), 20u);
  for (const double most : {1e-4, 2e-4}) {
    const std::vector<double> way = any_numbers(wanted.size(), most);
    double slope = 0;
    for (std::size_t n = 0; n < way.size(); n++) slope -= wanted[n] * way[n];
    const double difference = (there.energy_after(way, 0.5) - there.energy_after(way, -0.5));
    EXPECT_NEAR(difference, slope, 0.01 * std::abs(slope)) << "J";
  }
}

TEST(lattice_coarse_loops, inverses_of_the_factors_solve_what_the_factors_do) {
  There there;
  const CoarseView c = there.view();
  const std::vector<double> forces = any_numbers(std::size_t(c.numbers()), 1);
  const std::vector<double> expected = there.wounded.state.coarse->stiffness.solve(forces);
  std::copy(forces.begin(), forces.end(), c.wanted);
  multiply_with<1>(kShuffled, c.lower, c.wanted, c.piece_sums, c.halfway);
  multiply_with<1>(kShuffled, c.upper, c.halfway, c.piece_sums, c.way);
  double most = 0;
  for (const double x : expected) most = std::max(most, std::abs(x));
  EXPECT_GT(most, 0) << "m";
  for (std::size_t n = 0; n < expected.size(); n++)
    ASSERT_NEAR(c.way[n], expected[n], 1e-4 * most) << "m, number " << n;
}

TEST(lattice_coarse_loops, solving_for_the_smooth_part_never_raises_the_energy_of_a_step_there) {
  There there;
  State& state = there.wounded.state;
  double before = step_energy(kOne, there.wounded.model, state, there.inputs, kDt);
  for (int n = 0; n < 4; n++) {
    correct_smooth_part_with(kShuffled, there.body(), there.view());
    there.nodes.u.download(state.u), there.vbd.shifts.room.download(state.virtual_nodes);
    const double after = step_energy(kOne, there.wounded.model, state, there.inputs, kDt);
    EXPECT_LE(after, before * (1 + 1e-6)) << "J";
    EXPECT_TRUE(n > 0 || after < before) << after << " J after " << before;
    before = after;
  }
}

/// Gapes of the first frames, stepped here or there.
std::vector<double> course(const Params& params, int frames, double dt, bool there) {
  Wounded wounded(0.3, 0.5, 20, params);
  DeviceState state = std::move(wounded.state);
  if (there) state.step_on(put_on_host<SeededRun<1>>(wounded.model));
  std::vector<double> gapes;
  for (int n = 0; n < frames; n++) {
    EXPECT_TRUE(state.step(Exec(2), wounded.model, {}, dt).finite);
    gapes.push_back(measure_wound(wounded.model, state, wounded.path, 0).gape_max);
  }
  return gapes;
}

TEST(lattice_coarse_loops, a_wound_goes_its_way_there_with_five_sweeps_as_with_hundreds) {
  Params many = solid_params(200, 1.2, 45), few = solid_params(5, 1.2, 45);
  many.tissue.poisson = few.tissue.poisson = 0.45, many.solver.coarse = false;
  constexpr int kFrames = 6;
  many.solver.ordering = few.solver.ordering = Ordering::kColors;
  const std::vector<double> wanted = course(many, kFrames, kDt, false);
  double farthest[2] = {};
  for (const bool coarse : {false, true}) {
    few.solver.coarse = coarse;
    const std::vector<double> gapes = course(few, kFrames, kDt, true);
    for (std::size_t n = 0; n < kFrames; n++)
      farthest[coarse] = std::max(farthest[coarse], std::abs(gapes[n] - wanted[n]) / wanted.back());
  }
  std::printf("%.3f of the gape, %.3f by sweeps alone\n", farthest[1], farthest[0]);
  EXPECT_LT(farthest[1], 0.08) << "of the gape";
  EXPECT_GT(farthest[0], 0.5) << "of the gape, by sweeps alone";
}

TEST(lattice_coarse_loops, a_wound_comes_to_rest_there_where_slabs_without_a_coarse_space_bring_it) {
  Params params = solid_params(5, 8, 45), slabs = params;
  params.solver.ordering = Ordering::kColors, slabs.solver.coarse = false;
  const double there = course(params, 15, 1.0 / 30, true).back(),
               here = course(slabs, 60, 1.0 / 30, false).back();
  EXPECT_NEAR(there, here, 1e-4 * here) << "m";
}

/// A column on its foot, without lateral strain: how far gravity brings its top, the mean over its section.
struct Column {
  static constexpr Int3 kSize{5, 5, 25};
  static constexpr double kStep = 0.004, kYoung = 2e5;
  Model model;

  Column(int sweeps, bool coarse) {
    Params params = solid_params(sweeps, 8, 0);
    params.tissue.poisson = 0, params.skin.enabled = false;
    params.solver.coarse = coarse, params.solver.ordering = Ordering::kColors;
    model = block_model({.size = kSize,
                         .step = kStep,
                         .young = kYoung,
                         .skin_on_top = false,
                         .is_fixed = [](Int3 p) { return p.z == 0; }},
                        params);
  }
  double sag(int frames, double gravity, bool there = true) const {
    DeviceState state = make_state(model);
    if (there) state.step_on(put_on_host<SeededRun<1>>(model));
    for (int n = 0; n < frames; n++)
      EXPECT_TRUE(state.step(kOne, model, {.gravity = {0, 0, -gravity}}, 1.0 / 30).finite);
    double sum = 0;
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++) {
        const double x = i % (kSize.x - 1) ? 1 : 0.5, y = j % (kSize.y - 1) ? 1 : 0.5;
        sum -= x * y * double(state->u.z[std::size_t(node_slot(model.lattice, i, j, kSize.z - 1))]);
      }
    return sum / ((kSize.x - 1) * (kSize.y - 1));
  }
  /// Every layer of cells bears the nodes above it.
  double expected(double gravity) const {
    const double mass = 1 / double(model.inverse_mass[std::size_t(node_slot(model.lattice, 2, 2, 12))]);
    const double layer = mass * kSize.x * kSize.y * gravity,
                 area = (kSize.x - 1) * (kSize.y - 1) * kStep * kStep;
    double sag = 0;
    for (int k = 1; k < kSize.z; k++) sag += (kSize.z - k) * layer * kStep / (kYoung * area);
    return sag;
  }
};

TEST(lattice_coarse_loops, a_column_sags_there_by_the_weight_above_each_of_its_layers) {
  const Column column(5, true);
  for (const double gravity : {9.81, 3.0}) {
    const double expected = column.expected(gravity);
    EXPECT_NEAR(column.sag(60, gravity), expected, 0.01 * expected) << "m";
  }
}

TEST(lattice_coarse_loops, a_column_is_on_its_way_there_in_its_first_frames_as_after_hundreds_of_sweeps) {
  const Column few(5, true), alone(5, false), many(3000, false);
  for (const int frames : {1, 3}) {
    const double expected = many.sag(frames, 9.81, false);
    EXPECT_NEAR(few.sag(frames, 9.81), expected, 0.05 * expected) << "m, " << frames << " frames";
    EXPECT_LT(alone.sag(frames, 9.81), 0.3 * expected) << "m, by sweeps alone";
  }
}

TEST(lattice_coarse_loops, a_space_goes_over_when_it_is_made_and_frames_after_it_bring_back_a_few_bytes) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  wounded.model.params.solver.ordering = Ordering::kColors;
  DeviceState state = std::move(wounded.state);
  state.step_on(put_on_host<SeededRun<1>>(wounded.model));
  state.step(kOne, wounded.model, {}, kDt);
  const CoarseLists lists = coarse_lists(wounded.model, *state, *state->coarse);
  EXPECT_GE(lists.followers.size(), std::size_t(wounded.model.free_nodes));
  Bus::over = Bus::back = 0;
  for (int n = 0; n < 3; n++) state.step(kOne, wounded.model, {}, kDt);
  EXPECT_EQ(Bus::over, 3 * sizeof(StepMarks)) << "bytes";
  EXPECT_EQ(Bus::back, 3 * sizeof(StepMarks)) << "bytes";
  Bus::over = 0;
  state.step(kOne, wounded.model, {}, 2 * kDt);
  EXPECT_GE(Bus::over, sizeof(int) * lists.followers.size()) << "a space for longer steps";
  EXPECT_LE(Bus::over, 16 * lists.lower.terms.size() + 200 * lists.followers.size()) << "bytes";
}

}  // namespace
}  // namespace turgor::lattice

// Device kernels of the coarse correction. Each kernel is tested against another formulation, and bodies on
// the host backend, in shuffled order, against known states at rest.
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

using Backend = HostBackend<SeededRun<3>>;
const Exec kOne(1);
const SeededRun<3> kShuffled;
constexpr double kDt = 1.0 / 60;

/// A wound with random displacements on the host backend.
struct OnHostBackend {
  Wounded wounded{0.3, 0.5, 20, solid_params(5, 4, 45)};
  Inputs inputs{.gravity = {1, 2, -9}};
  DeviceAllocator<Backend> allocator;
  DeviceNodes<Backend> nodes{allocator, wounded.model};
  DeviceVbd<Backend> vbd{allocator, wounded.model};
  DeviceCoarse<Backend> coarse{allocator, wounded.model};

  OnHostBackend() {
    const Model& model = wounded.model;
    State& state = wounded.state;
    scatter(model, state, 0.0005);
    predict(kOne, model, state, inputs, kDt);
    EXPECT_TRUE(prepare_coarse_space(model, state, inputs, kDt));
    nodes.u.upload(state.motion.u), nodes.u_before.upload(state.motion.u_before),
        nodes.v.upload(state.motion.v);
    nodes.upload_cuts(state.cuts);
    vbd.upload_cuts(model, state.cuts, state.cut_elements, state.motion.virtual_u,
                    state.motion.virtual_u_before);
    coarse.upload(model, state.cut_elements, state.motion.virtual_u.size(), state.workspace.coarse);
  }
  VbdView body() const { return vbd.view(wounded.model, nodes, inputs, kDt); }
  CoarseView view() const { return coarse.view(wounded.model); }

  /// Energy of the step after the unknowns have moved by a fraction of a direction.
  double energy_after(const std::vector<double>& direction, Real fraction) {
    const CoarseView c = view();
    std::copy(direction.begin(), direction.end(), c.correction);
    c.search->change = fraction;
    multiply_with<3>(kShuffled, c.to_corners, c.correction, c.segment_sums, c.corners);
    kShuffled(std::size_t(c.chunk_count) * kTermsPerThread,
              ProlongateNode{c, body().body.nodes, body().cut_elements.virtual_nodes});
    State moved = wounded.state;
    nodes.u.download(moved.motion.u), vbd.shifts.array.download(moved.motion.virtual_u);
    nodes.u.upload(wounded.state.motion.u), vbd.shifts.assign(wounded.state.motion.virtual_u);
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

// The restricted residual is the slope of the energy along the coarse unknowns.
TEST(CoarseKernels, RestrictionIsEnergySlope) {
  OnHostBackend scene;
  const CoarseView c = scene.view();
  restrict_residual_with(kShuffled, scene.body(), c);
  const std::vector<double> wanted(c.restricted_residual, c.restricted_residual + c.numbers());
  ASSERT_GT(scene.wounded.state.motion.virtual_u.size(), 20u);
  for (const double most : {2.5e-5, 5e-5}) {
    const std::vector<double> direction = any_numbers(wanted.size(), most);
    double slope = 0;
    for (std::size_t n = 0; n < direction.size(); n++) slope -= wanted[n] * direction[n];
    const double difference = (scene.energy_after(direction, 0.5) - scene.energy_after(direction, -0.5));
    EXPECT_NEAR(difference, slope, 0.01 * std::abs(slope)) << "J";
  }
}

// Products with the inverse factors match a solve with the factors.
TEST(CoarseKernels, InverseFactorsMatchSolve) {
  OnHostBackend scene;
  const CoarseView c = scene.view();
  const std::vector<double> forces = any_numbers(std::size_t(c.numbers()), 1);
  const std::vector<double> expected = scene.wounded.state.workspace.coarse->factor.solve(forces);
  std::copy(forces.begin(), forces.end(), c.restricted_residual);
  multiply_with<1>(kShuffled, c.lower, c.restricted_residual, c.segment_sums, c.intermediate);
  multiply_with<1>(kShuffled, c.upper, c.intermediate, c.segment_sums, c.correction);
  double most = 0;
  for (const double x : expected) most = std::max(most, std::abs(x));
  EXPECT_GT(most, 0) << "m";
  for (std::size_t n = 0; n < expected.size(); n++)
    ASSERT_NEAR(c.correction[n], expected[n], 1e-4 * most) << "m, number " << n;
}

// The coarse correction never raises the energy of the step.
TEST(CoarseKernels, CorrectionNeverRaisesEnergy) {
  OnHostBackend scene;
  State& state = scene.wounded.state;
  double before = step_energy(kOne, scene.wounded.model, state, scene.inputs, kDt);
  for (int n = 0; n < 4; n++) {
    correct_two_grid(CorrectionKernels<SeededRun<3>>{kShuffled, scene.body(), scene.view()});
    scene.nodes.u.download(state.motion.u), scene.vbd.shifts.array.download(state.motion.virtual_u);
    const double after = step_energy(kOne, scene.wounded.model, state, scene.inputs, kDt);
    EXPECT_LE(after, before * (1 + 1e-6)) << "J";
    EXPECT_TRUE(n > 0 || after < before) << after << " J after " << before;
    before = after;
  }
}

/// Gapes of the first frames, on the CPU or on the host backend.
std::vector<double> course(const Params& params, int frames, double dt, bool on_device) {
  Wounded wounded(0.3, 0.5, 20, params);
  DeviceState state = std::move(wounded.state);
  if (on_device) state.use_backend(put_on_host<SeededRun<1>>(wounded.model));
  std::vector<double> gapes;
  for (int n = 0; n < frames; n++) {
    EXPECT_TRUE(state.step(Exec(2), wounded.model, {}, dt).finite);
    gapes.push_back(measure_wound(wounded.model, state, wounded.path, 0).gape_max);
  }
  return gapes;
}

// With the coarse correction, a wound opens with five sweeps as with hundreds without it.
TEST(CoarseKernels, FiveSweepsFollowConvergedWound) {
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

// A wound has the same gape at rest as with slabs on the CPU without a coarse space.
TEST(CoarseKernels, RestingWoundMatchesSlabs) {
  Params params = solid_params(5, 8, 45), slabs = params;
  params.solver.ordering = Ordering::kColors, slabs.solver.coarse = false;
  const double device = course(params, 15, 1.0 / 30, true).back(),
               host = course(slabs, 60, 1.0 / 30, false).back();
  EXPECT_NEAR(device, host, 1e-4 * host) << "m";
}

/// A column on its foot without lateral strain: the displacement of its top under gravity, averaged over the
/// section.
struct Column {
  static constexpr Int3 kSize{5, 5, 25};
  static constexpr double kStep = 0.004, kYoung = 2e5;
  Model model;

  Column(int sweeps, bool coarse) {
    Params params = solid_params(sweeps, 8, 0);
    params.tissue.poisson = 0, params.skin.enabled = false;
    params.solver.coarse = coarse, params.solver.ordering = Ordering::kColors;
    model = block_model({.size = kSize,
                         .spacing = kStep,
                         .young = kYoung,
                         .skin_on_top = false,
                         .is_fixed = [](Int3 p) { return p.z == 0; }},
                        params);
  }
  double sag(int frames, double gravity, bool on_device = true) const {
    DeviceState state = make_state(model);
    if (on_device) state.use_backend(put_on_host<SeededRun<1>>(model));
    for (int n = 0; n < frames; n++)
      EXPECT_TRUE(state.step(kOne, model, {.gravity = {0, 0, -gravity}}, 1.0 / 30).finite);
    double sum = 0;
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++) {
        const double x = i % (kSize.x - 1) ? 1 : 0.5, y = j % (kSize.y - 1) ? 1 : 0.5;
        sum -= x * y *
               double(state->motion.u.z[std::size_t(node_slot(model.anatomy.lattice, i, j, kSize.z - 1))]);
      }
    return sum / ((kSize.x - 1) * (kSize.y - 1));
  }
  /// Every layer of cells carries the nodes above it.
  double expected(double gravity) const {
    const double mass =
        1 / double(model.anatomy.inverse_mass[std::size_t(node_slot(model.anatomy.lattice, 2, 2, 12))]);
    const double layer = mass * kSize.x * kSize.y * gravity,
                 area = (kSize.x - 1) * (kSize.y - 1) * kStep * kStep;
    double sag = 0;
    for (int k = 1; k < kSize.z; k++) sag += (kSize.z - k) * layer * kStep / (kYoung * area);
    return sag;
  }
};

// A column sags by the weight above each of its layers.
TEST(CoarseKernels, ColumnSagsByItsWeight) {
  const Column column(5, true);
  for (const double gravity : {9.81, 3.0}) {
    const double expected = column.expected(gravity);
    EXPECT_NEAR(column.sag(60, gravity), expected, 0.01 * expected) << "m";
  }
}

// In the first frames, a column moves as with thousands of sweeps.
TEST(CoarseKernels, ColumnMotionMatchesManySweeps) {
  const Column few(5, true), alone(5, false), many(3000, false);
  for (const int frames : {1, 3}) {
    const double expected = many.sag(frames, 9.81, false);
    EXPECT_NEAR(few.sag(frames, 9.81), expected, 0.05 * expected) << "m, " << frames << " frames";
    EXPECT_LT(alone.sag(frames, 9.81), 0.3 * expected) << "m, by sweeps alone";
  }
}

// A coarse space is uploaded once; later frames transfer only a summary.
TEST(CoarseKernels, SpaceIsUploadedOnce) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  wounded.model.params.solver.ordering = Ordering::kColors;
  DeviceState state = std::move(wounded.state);
  state.use_backend(put_on_host<SeededRun<1>>(wounded.model));
  state.step(kOne, wounded.model, {}, kDt);
  const CoarseLists lists = coarse_lists(wounded.model, state->cut_elements, state->motion.virtual_u.size(),
                                         *state->workspace.coarse);
  EXPECT_GE(lists.fine_nodes.size(), std::size_t(wounded.model.anatomy.free_nodes));
  Transfers::uploaded = Transfers::downloaded = 0;
  for (int n = 0; n < 3; n++) state.step(kOne, wounded.model, {}, kDt);
  EXPECT_EQ(Transfers::uploaded, 3 * sizeof(StepSummary)) << "bytes";
  EXPECT_EQ(Transfers::downloaded, 3 * sizeof(StepSummary)) << "bytes";
  Transfers::uploaded = 0;
  state.step(kOne, wounded.model, {}, 2 * kDt);
  EXPECT_GE(Transfers::uploaded, sizeof(int) * lists.fine_nodes.size()) << "a space for longer steps";
  EXPECT_LE(Transfers::uploaded, 16 * lists.lower.terms.size() + 200 * lists.fine_nodes.size()) << "bytes";
}

}  // namespace
}  // namespace turgor::lattice

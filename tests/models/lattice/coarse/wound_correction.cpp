// The coarse correction of a body with a wound, and the steps that build its coarse space.
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kOneThread(1);

/// Gapes of the first frames at 60 Hz.
std::vector<double> opening(Wounded wounded, int frames) {
  std::vector<double> gapes;
  for (int n = 0; n < frames; n++) {
    EXPECT_TRUE(step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 60).finite);
    gapes.push_back(measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max);
  }
  return gapes;
}

// With the coarse correction, a wound opens with five sweeps as with hundreds without it.
TEST(WoundCorrection, FiveSweepsFollowConvergedWound) {
  for (const auto& [aside, degrees] : {std::pair{0.3, 20.0}, {0.2, 110.0}}) {
    Params many = solid_params(200, 1.2, 45), few = solid_params(5, 1.2, 45);
    many.tissue.poisson = few.tissue.poisson = 0.45, many.solver.coarse = false;
    constexpr int kFrames = 8;
    const std::vector<double> wanted = opening(Wounded(aside, 0.5, degrees, many), kFrames);
    double farthest[2] = {};
    for (const bool coarse : {false, true}) {
      few.solver.coarse = coarse;
      const std::vector<double> gapes = opening(Wounded(aside, 0.5, degrees, few), kFrames);
      for (int n = 0; n < kFrames; n++)
        farthest[coarse] = std::max(farthest[coarse],
                                    std::abs(gapes[std::size_t(n)] - wanted[std::size_t(n)]) / wanted.back());
    }
    std::printf("%.1f aside, %3.0f degrees: %.3f of the gape, %.3f by sweeps alone\n", aside, degrees,
                farthest[1], farthest[0]);
    EXPECT_LT(farthest[1], 0.08) << "of the gape, " << degrees << " degrees";
    EXPECT_GT(farthest[0], 0.5) << "of the gape, by sweeps alone";
  }
}

// The coarse correction does not change the gape at rest.
TEST(WoundCorrection, CoarseCorrectionKeepsRestState) {
  double gapes[2];
  for (const bool coarse : {false, true}) {
    Params params = solid_params(5, 4, 45);
    params.solver.coarse = coarse;
    Wounded wounded(0.3, 0.5, 20, params);
    for (int n = 0; n < 240; n++) step(Exec(2), wounded.model, wounded.state, {}, 1.0 / 60);
    gapes[coarse] = measure_wound(wounded.model, wounded.state, wounded.path, 0).gape_max;
  }
  EXPECT_NEAR(gapes[1], gapes[0], 1e-4 * gapes[0]) << "m";
}

// The residual summed by cells equals that summed by nodes.
TEST(WoundCorrection, ResidualByCellsMatchesNodes) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  const Model& model = wounded.model;
  State& state = wounded.state;
  scatter(model, state, 0.0005);
  const Inputs inputs{.gravity = {1, 2, -9}};
  predict(kOneThread, model, state, inputs, 1.0 / 60);
  ASSERT_TRUE(prepare_coarse_space(model, state, inputs, 1.0 / 60));
  double sum2 = 0;
  const auto see = [&](int, int k, LayerForces forces) {
    for (int s = row_slot(model.anatomy.lattice, 0, k); s < row_slot(model.anatomy.lattice, Wounded::kN, k);
         s++)
      if (model.anatomy.inverse_mass[std::size_t(s)] > 0) sum2 += dot(Vec3d(forces[s]), Vec3d(forces[s]));
  };
  visit_residual_forces(kOneThread, model, state, *state.workspace.coarse, inputs, 1.0 / 60,
                        state.workspace.residual, see);
  for (const ElementNode& copy : state.cut_elements.virtual_nodes) {
    if (model.anatomy.inverse_mass[std::size_t(copy.slot)] == 0) continue;
    const VirtualNodeDisplacement& f =
        state.workspace.residual.virtual_nodes[std::size_t(copy.corner - slot_count(model.anatomy.lattice))];
    sum2 += dot(Vec3d{f.x, f.y, f.z}, Vec3d{f.x, f.y, f.z});
  }
  const double rms = measure_residual(kOneThread, model, state, inputs, 1.0 / 60).rms;
  EXPECT_NEAR(std::sqrt(sum2 / model.anatomy.free_nodes), rms, 1e-4 * rms) << "N";
}

// The coarse correction never raises the energy of the step.
TEST(WoundCorrection, CorrectionNeverRaisesEnergy) {
  for (const double amplitude : {1e-5, 5e-4, 4e-3}) {
    Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
    const Model& model = wounded.model;
    State& state = wounded.state;
    scatter(model, state, amplitude);
    predict(kOneThread, model, state, {}, 1.0 / 60);
    ASSERT_TRUE(prepare_coarse_space(model, state, {}, 1.0 / 60));
    double before = step_energy(kOneThread, model, state, {}, 1.0 / 60);
    for (int n = 0; n < 4; n++) {
      apply_coarse_correction(kOneThread, model, state, {}, 1.0 / 60);
      const double after = step_energy(kOneThread, model, state, {}, 1.0 / 60);
      EXPECT_LE(after, before * (1 + 1e-6)) << "J, amplitude " << amplitude << " m";
      before = after;
    }
  }
}

// A coarse space is reused for rounded or shorter time steps, and rebuilt for longer ones.
TEST(WoundCorrection, SpaceIsReusedForShorterSteps) {
  Wounded wounded(0.3, 0.5, 20, solid_params(5, 4, 45));
  const auto space_after = [&](double dt) {
    step(kOneThread, wounded.model, wounded.state, {}, dt);
    return wounded.state.workspace.coarse.get();
  };
  const CoarseSpace* first = space_after(1.0 / 60);
  EXPECT_NE(first, nullptr);
  EXPECT_EQ(space_after(8.0 / 60 - 7.0 / 60), first);
  EXPECT_EQ(space_after(1.0 / 180), first) << "a third of a frame";
  EXPECT_EQ(space_after(1.0 / 60), first);
  const std::shared_ptr<const CoarseSpace> kept = wounded.state.workspace.coarse;
  EXPECT_NE(space_after(1.0 / 30), first);
}

/// Counts the coarse spaces built during some steps after a section of the path was cut.
struct SpaceCounter {
  Wounded wounded;
  std::shared_ptr<const CoarseSpace> last;  // retained, so that no other space has its address

  SpaceCounter() : wounded(0.3, 0.5, 20, solid_params(5, 4, 45)) {
    wounded.state = make_state(wounded.model);
    steps(3);
  }
  int steps(int count, Vec3d gravity = {}) {
    int made = 0;
    for (int n = 0; n < count; n++) {
      step(kOneThread, wounded.model, wounded.state, {.gravity = gravity}, 1.0 / 60);
      made += wounded.state.workspace.coarse != last;
      last = wounded.state.workspace.coarse;
    }
    return made;
  }
  int cut(double begin, double end, int count) {
    cut_edges(wounded.model, wounded.state, wounded.path, begin, end, 0);
    return steps(count);
  }
};

// A body at rest builds no coarse space before it moves.
TEST(WoundCorrection, RestingBodyBuildsNoSpace) {
  SpaceCounter counter;
  EXPECT_EQ(counter.steps(3), 0);
  EXPECT_EQ(counter.last, nullptr);
  EXPECT_EQ(counter.steps(1, {0, 0, -9}), 1) << "gravity";
  EXPECT_EQ(counter.steps(3), 0) << "while it keeps moving";
}

// A moving blade builds no coarse space before the cut is complete, and then one.
TEST(WoundCorrection, MovingBladeBuildsOneSpaceAtEnd) {
  for (const int steps_per_cut : {1, 3}) {
    SpaceCounter moving;
    int before_the_end = 0;
    for (int n = 0; n < 9; n++) before_the_end += moving.cut(n / 10.0, (n + 1) / 10.0, steps_per_cut);
    EXPECT_EQ(before_the_end, 0);
    EXPECT_EQ(moving.cut(0.9, 1, 1), 1) << "in the step that completes the cut";
    EXPECT_EQ(moving.steps(12), 0);
  }
}

// An instant cut builds one coarse space in its first step.
TEST(WoundCorrection, InstantCutBuildsSpaceInFirstStep) {
  SpaceCounter at_once;
  EXPECT_EQ(at_once.cut(0, 1, 1), 1);
  EXPECT_EQ(at_once.steps(12), 0);
}

// A blade that stops halfway gets a coarse space within a few steps.
TEST(WoundCorrection, StoppedBladeBuildsSpaceSoon) {
  SpaceCounter stopped;
  EXPECT_EQ(stopped.cut(0, 0.5, 4), 0);
  EXPECT_EQ(stopped.steps(8), 1);
  EXPECT_EQ(stopped.cut(0.5, 1, 1), 1) << "and one when the cut is completed";
}

}  // namespace
}  // namespace turgor::lattice

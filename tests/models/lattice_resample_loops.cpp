// The deformed CT by the loops that a GPU runs, in any order, against the one of the CPU.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "ct_body.hpp"
#include "host_side.hpp"
#include "turgor/models/lattice/resample.hpp"
#include "turgor/models/lattice/resample_loops.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(2);
constexpr ResampleOptions kAlone{.conserve_mass = false, .keep_surroundings = false};

/// Bent, and where `fold` is large folded over itself.
State waved(const Model& model, double fold) {
  State state = make_state(model);
  move(model, state, [fold](Vec3d x) {
    return Vec3d{0.003 * std::sin(300 * x.y) + 0.0004, fold * std::sin(400 * x.x),
                 0.002 * std::cos(250 * x.z) - 0.001};
  });
  return state;
}

/// Turned, finer along one axis, and mirrored.
Grid other_grid(const Grid& ct) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  return {.size = {24, 35, 30},
          .spacing = {0.0011, 0.0007, 0.0013},
          .origin = ct.origin + Vec3d{0.002, 0.001, 0.045},
          .axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, -1}}}};
}

template <class R>
CtVolume by_loops(const Model& model, const State& state, const CtVolume& ct, const Grid& grid) {
  const std::shared_ptr<BodyThere> there = put_on_host<R>(model);
  there->put_state(model, state);
  return there->resample(model, ct, grid).value();
}

TEST(lattice_resample_loops, in_any_order_are_the_ct_that_the_cpu_makes) {
  const CtVolume ct = ball_ct(33, 12.3);
  long overlaps = 0;
  for (const Int3 block : {Int3{4, 4, 4}, {3, 5, 2}})
    for (const double fold : {0.0, 0.004}) {
      const Model model = body_of(ct, block);
      const State state = waved(model, fold);
      for (const Grid& grid : {ct.grid, resized(ct.grid, {22, 30, 41}), other_grid(ct.grid)}) {
        const ResampledCt here = resample_ct(kExec, model, state, ct, grid, kAlone);
        overlaps += here.report.overlaps;
        const CtVolume one = by_loops<SeededRun<1>>(model, state, ct, grid);
        EXPECT_EQ(one.samples, (by_loops<SeededRun<2>>(model, state, ct, grid).samples));
        EXPECT_EQ(one.samples, (by_loops<ThreadedRun<8>>(model, state, ct, grid).samples));
        long tissue = 0, other = 0;
        for (std::size_t v = 0; v < one.samples.size(); v++) {
          tissue += here.ct.samples[v] != kAirHu;
          other += one.samples[v] != here.ct.samples[v];
        }
        EXPECT_GT(tissue, 1000);
#ifdef TURGOR_SAME_BITS
        EXPECT_EQ(other, 0);
#else
        EXPECT_LE(other, tissue / 2000) << "of " << tissue << " voxels: fused multiply-adds round otherwise";
#endif
      }
    }
  EXPECT_GT(overlaps, 500) << "voxels that several tetrahedra claim";
}

TEST(lattice_resample_loops, what_is_away_is_resampled_there_and_the_picture_alone_comes_back) {
  const CtVolume ct = ball_ct(33, 12);
  const Model model = body_of(ct, {3, 3, 3});
  KeptState state = waved(model, 0);
  state.step_on(put_on_host<SeededRun<1>>(model));
  const Inputs inputs{.gravity = {0, 0, -9.81}};
  for (int n = 0; n < 2; n++) EXPECT_TRUE(state.step(kExec, model, inputs, 1e-3).finite);
  Bus::over = Bus::back = 0;
  const CtVolume now = state.resample(kExec, model, ct, ct.grid);
  EXPECT_EQ(Bus::back, now.samples.size() * sizeof(std::int16_t) + sizeof(MovedBits));
  Bus::over = 0;
  (void)state.resample(kExec, model, ct, ct.grid);
  EXPECT_EQ(Bus::over, sizeof(MovedBits)) << "the CT is there";
  const CtVolume fetched = resample_ct(kExec, model, state, ct, ct.grid, kAlone).ct;
  long other = 0;
  for (std::size_t v = 0; v < now.samples.size(); v++) other += now.samples[v] != fetched.samples[v];
  EXPECT_LE(other, 8) << "voxels: fused multiply-adds round otherwise";
  EXPECT_EQ(state.resample(kExec, model, ct, ct.grid).samples, fetched.samples) << "it is here";
}

TEST(lattice_resample_loops, a_body_that_was_cut_is_resampled_here) {
  const CtVolume ct = ball_ct(33, 12);
  const Model model = body_of(ct, {3, 3, 3});
  State cut = waved(model, 0);
  ASSERT_GT(cut_across_y(model, cut, 0.016, [](Vec3d x) { return x.z > 0.016; }), 10);
  KeptState state = cut;
  state.step_on(put_on_host<SeededRun<1>>(model));
  EXPECT_TRUE(state.step(kExec, model, {}, 1e-3).finite);
  Bus::back = 0;
  const CtVolume now = state.resample(kExec, model, ct, ct.grid);
  EXPECT_GE(Bus::back, 9 * sizeof(Real) * model.inverse_mass.size()) << "it comes back";
  EXPECT_EQ(now.samples, resample_ct(kExec, model, state, ct, ct.grid, kAlone).ct.samples);
}

}  // namespace
}  // namespace turgor::lattice

// The deformed CT by the loops that a GPU runs, in any order, against the one of the CPU.
#include "turgor/models/lattice/resample/resample_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include <gtest/gtest.h>

#include "tests/models/host_side.hpp"
#include "tests/models/lattice/cut_ball.hpp"
#include "turgor/models/lattice/resample/resample.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(2);
constexpr ResampleOptions kAlone{.conserve_mass = false, .keep_surroundings = false};
/// Bytes beside the voxels that go over and come back: how far the body has moved, and what is counted.
constexpr std::size_t kTold = sizeof(MovedBits) + kCountParts * sizeof(ResampleCounts);

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
ResampledCt by_loops(const Model& model, const State& state, const CtVolume& ct, const Grid& grid,
                     const ResampleOptions& options) {
  const std::shared_ptr<BodyBackend> there = put_on_host<R>(model);
  there->put_state(model, state);
  const DeviceResampled made = there->resample(kExec, model, state, ct, grid, options).value();
  ResampledCt now{.ct = {.grid = grid, .samples = {}}, .report = made.report};
  now.ct.samples.resize(sample_count(grid));
  made.samples->get(now.ct.samples);
  return now;
}

/// Voxels that are not air, and those that others made otherwise.
struct Compared {
  long tissue = 0, other = 0;
};
Compared compared(const CtVolume& there, const CtVolume& here) {
  Compared found;
  for (std::size_t v = 0; v < here.samples.size(); v++) {
    found.tissue += here.samples[v] != kAirHu;
    found.other += there.samples[v] != here.samples[v];
  }
  return found;
}

/// The CT that loops make in any order and the CPU's are the same, and so is what is told of them.
void expect_the_cpus_ct(const Model& model, const State& state, const CtVolume& ct, const Grid& grid,
                        const ResampleOptions& options) {
  const auto by = [&]<class R>(R) { return by_loops<R>(model, state, ct, grid, options); };
  const ResampledCt here = resample_ct(kExec, model, state, ct, grid, options);
  const ResampledCt one = by(SeededRun<1>{});
  for (const ResampledCt& other :
       {by(SeededRun<2>{}), by(ThreadedRun<1>{}), by(ThreadedRun<2>{}), by(ThreadedRun<8>{})}) {
    EXPECT_EQ(one.ct.samples, other.ct.samples);
    EXPECT_EQ(one.report.mass_error, other.report.mass_error);
  }
  EXPECT_EQ(one.report.folds, here.report.folds);
  EXPECT_EQ(one.report.overlaps, here.report.overlaps);
  EXPECT_NEAR(one.report.mass_error, here.report.mass_error, 1e-6);
  const Compared found = compared(one.ct, here.ct);
  EXPECT_GT(found.tissue, 1000);
#ifdef TURGOR_SAME_BITS
  EXPECT_EQ(found.other, 0);
#else
  EXPECT_LE(found.other, found.tissue / 2000)
      << "of " << found.tissue << " voxels: fused multiply-adds round otherwise";
#endif
}

TEST(lattice_resample_loops, in_any_order_are_the_ct_that_the_cpu_makes) {
  const CtVolume ct = ball_ct(33, 12.3);
  long overlaps = 0;
  for (const Int3 block : {Int3{4, 4, 4}, {3, 5, 2}})
    for (const double fold : {0.0, 0.004}) {
      const Model model = body_of(ct, block);
      const State state = waved(model, fold);
      for (const Grid& grid : {ct.grid, resized(ct.grid, {22, 30, 41}), other_grid(ct.grid)}) {
        overlaps += resample_ct(kExec, model, state, ct, grid, kAlone).report.overlaps;
        expect_the_cpus_ct(model, state, ct, grid, {.keep_surroundings = fold == 0});
      }
    }
  EXPECT_GT(overlaps, 500) << "voxels that several tetrahedra claim";
}

TEST(lattice_resample_loops, take_the_blur_of_the_skin_along_and_leave_a_table) {
  CtVolume ct = blurred_ball_ct(40, 12.4, true);
  for_voxels(ct.grid, [&](Int3 p) {  // a table and its cover
    if (p.y > 32 && p.y < 37) ct.at(p.x, p.y, p.z) = p.y == 33 ? -600 : std::int16_t(-300 + p.x);
  });
  for (const Int3 block : {Int3{2, 2, 2}, {3, 5, 4}}) {
    const Model model = body_of(ct, block);
    State state = make_state(model);
    expect_the_cpus_ct(model, state, ct, ct.grid, {});
    EXPECT_EQ(by_loops<SeededRun<3>>(model, state, ct, ct.grid, {}).ct.samples, ct.samples) << "at rest";
    cut_across_y(model, state, 0.0203, [](Vec3d x) { return x.z > 0.012; });
    move(model, state, [&](Vec3d x) {
      return wobble(x, 0.001, 0.05, 0.3) + Vec3d{0.0003, x.y >= 0.0203 ? 0.0004 : -0.004, 0};
    });
    for (const Grid& grid : {ct.grid, resized(ct.grid, {27, 80, 40}), other_grid(ct.grid)})
      expect_the_cpus_ct(model, state, ct, grid, {});
  }
}

TEST(lattice_resample_loops, what_is_away_is_resampled_there_and_the_picture_alone_comes_back) {
  const CtVolume ct = ball_ct(33, 12);
  const Model model = body_of(ct, {3, 3, 3});
  DeviceState state = waved(model, 0);
  state.step_on(put_on_host<SeededRun<1>>(model));
  const Inputs inputs{.gravity = {0, 0, -9.81}};
  for (int n = 0; n < 2; n++) EXPECT_TRUE(state.step(kExec, model, inputs, 1e-3).finite);
  Bus::over = Bus::back = 0;
  const CtVolume now = state.resample(kExec, model, ct, ct.grid, kAlone).ct;
  EXPECT_EQ(Bus::back, now.samples.size() * sizeof(std::int16_t) + kTold);
  Bus::over = 0;
  (void)state.resample(kExec, model, ct, ct.grid, kAlone);
  EXPECT_EQ(Bus::over, kTold) << "the CT is there";
  const CtVolume fetched = resample_ct(kExec, model, state, ct, ct.grid, kAlone).ct;
  EXPECT_LE(compared(now, fetched).other, 8) << "voxels: fused multiply-adds round otherwise";
  EXPECT_EQ(state.resample(kExec, model, ct, ct.grid, kAlone).ct.samples, now.samples)
      << "it is here and there";
  state.change().u.x[std::size_t(node_slot(model.lattice, 5, 5, 5))] += 1e-4f;
  EXPECT_EQ(state.resample(kExec, model, ct, ct.grid, kAlone).ct.samples,
            resample_ct(kExec, model, state, ct, ct.grid, kAlone).ct.samples)
      << "only here";
}

TEST(lattice_resample_loops, of_a_body_in_pieces_are_the_ct_that_the_cpu_makes) {
  for (const CutBall& ball : {CutBall({}), CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd}),
                              CutBall({}, TissueLaw::kSprings, {4, 3, 2})}) {
    const Fragments pieces = make_fragments(ball.model, ball.state);
    ASSERT_GT(pieces.virtual_nodes.size(), 20u);
    EXPECT_EQ(ball.state.virtual_nodes.size() == pieces.virtual_nodes.size(),
              ball.model.params.tissue.law == TissueLaw::kSolid)
        << "copies are solved for";
    expect_the_cpus_ct(ball.model, ball.state, ball.ct, ball.ct.grid, {.conserve_mass = true});
    expect_the_cpus_ct(ball.model, ball.state, ball.ct, other_grid(ball.ct.grid), kAlone);
  }
}

TEST(lattice_resample_loops, of_a_body_that_nodes_left_are_the_ct_that_the_cpu_makes) {
  CutBall ball({});
  ASSERT_GT(cut_region(ball.model, ball.state, ball.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
  expect_the_cpus_ct(ball.model, ball.state, ball.ct, ball.ct.grid, {});
  CutBall whole({});
  whole.state = make_state(whole.model);
  ASSERT_GT(cut_region(whole.model, whole.state, whole.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
  expect_the_cpus_ct(whole.model, whole.state, whole.ct, whole.ct.grid, {});
}

/// Fields that loops make in any order, and what the CPU makes.
void expect_the_cpus_fields(const Model& model, const State& state, const Grid& grid) {
  const VectorVolume u = resample_displacement(kExec, model, state, grid);
  const ScalarVolume ratio = resample_jacobian(kExec, model, state, grid);
  const auto by = [&]<class R>(R) {
    const std::shared_ptr<BodyBackend> there = put_on_host<R>(model);
    there->put_state(model, state);
    std::pair<std::vector<Vec3>, std::vector<float>> made(sample_count(grid), sample_count(grid));
    EXPECT_TRUE(there->get_displacement(model, state, grid, made.first));
    EXPECT_TRUE(there->get_jacobian(model, state, grid, made.second));
    return made;
  };
  const auto one = by(SeededRun<1>{});
  EXPECT_EQ(one, by(SeededRun<2>{}));
  EXPECT_EQ(one, by(ThreadedRun<8>{}));
  long tissue = 0, other = 0, wrong = 0;
  for (std::size_t v = 0; v < ratio.samples.size(); v++) {
    const float apart = norm(one.first[v] - u.samples[v]);
    const float ratio_apart = std::abs(one.second[v] - ratio.samples[v]) / std::max(1.0f, ratio.samples[v]);
    tissue += ratio.samples[v] != 1 || norm(u.samples[v]) > 0;
    other += apart > 1e-8f || ratio_apart > 1e-6f;
    wrong += apart > 2e-6f || ratio_apart > 5e-3f;
  }
  EXPECT_GT(tissue, 1000);
#ifdef TURGOR_SAME_BITS
  EXPECT_EQ(one.first, u.samples);
  EXPECT_EQ(one.second, ratio.samples);
#else
  EXPECT_LE(other, tissue / 50)
      << "of " << tissue << " voxels: fused multiply-adds may place a corner a 1024th of a voxel aside";
  EXPECT_LE(wrong, tissue / 2000);
#endif
}

/// Axes that are not the patient's, and no two spacings alike.
CtVolume turned_ct(CtVolume ct) {
  const double c = std::cos(0.4), s = std::sin(0.4);
  ct.grid.spacing = {0.0009, 0.0013, 0.0011};
  ct.grid.axes = {{{c, s, 0}, {-s * c, c * c, s}, {s * s, -c * s, c}}};
  return ct;
}

TEST(lattice_resample_loops, make_displacements_and_jacobians_of_the_cpu_in_any_order) {
  for (const CtVolume& ct : {ball_ct(33, 12.3), turned_ct(ball_ct(30, 11.2))})
    for (const Int3 block : {Int3{4, 4, 4}, {3, 5, 2}})
      for (const double fold : {0.0, 0.004}) {
        const Model model = body_of(ct, block);
        const State state = waved(model, fold);
        for (const Grid& grid : {ct.grid, resized(ct.grid, {22, 30, 41}), other_grid(ct.grid)})
          expect_the_cpus_fields(model, state, grid);
      }
}

TEST(lattice_resample_loops, make_fields_of_a_body_in_pieces) {
  for (CutBall& ball :
       std::vector{CutBall({}), CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd}),
                   CutBall({}, TissueLaw::kSprings, {4, 3, 2})}) {
    expect_the_cpus_fields(ball.model, ball.state, resized(ball.ct.grid, ball.ct.grid.size * 2));
    expect_the_cpus_fields(ball.model, ball.state, other_grid(ball.ct.grid));
    ASSERT_GT(cut_region(ball.model, ball.state, ball.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
    expect_the_cpus_fields(ball.model, ball.state, ball.ct.grid);
  }
}

TEST(lattice_resample_loops, of_fields_what_was_asked_for_alone_comes_back) {
  CutBall ball({}, TissueLaw::kSolid);
  DeviceState state = ball.state;
  state.step_on(put_on_host<SeededRun<1>>(ball.model));
  EXPECT_TRUE(state.step(kExec, ball.model, {}, 1e-3).finite);
  const std::size_t voxels = sample_count(ball.ct.grid);
  Bus::back = 0;
  const VectorVolume u = state.resample_displacement(kExec, ball.model, ball.ct.grid);
  EXPECT_EQ(Bus::back, voxels * sizeof(Vec3) + sizeof(MovedBits));
  Bus::over = Bus::back = 0;
  const ScalarVolume ratio = state.resample_jacobian(kExec, ball.model, ball.ct.grid);
  EXPECT_EQ(Bus::back, voxels * sizeof(float) + sizeof(MovedBits));
  EXPECT_EQ(Bus::over, kTold) << "pieces are there, and nobody asked for the CT";
  const CtVolume now = state.resample(kExec, ball.model, ball.ct, ball.ct.grid, kAlone).ct;
  const CtVolume here = resample_ct(kExec, ball.model, state, ball.ct, ball.ct.grid, kAlone).ct;
  EXPECT_LE(compared(now, here).other, 8) << "and then HU";
  const VectorVolume u_here = resample_displacement(kExec, ball.model, state, ball.ct.grid);
  const ScalarVolume ratio_here = resample_jacobian(kExec, ball.model, state, ball.ct.grid);
  for (std::size_t v = 0; v < voxels; v++) {
    ASSERT_LT(norm(u.samples[v] - u_here.samples[v]), 1e-8) << "m, voxel " << v;
    ASSERT_NEAR(ratio.samples[v], ratio_here.samples[v], 1e-6) << "voxel " << v;
  }
  state.change().u.x[std::size_t(node_slot(ball.model.lattice, 5, 5, 5))] += 1e-4f;
  EXPECT_EQ(state.resample_displacement(kExec, ball.model, ball.ct.grid).samples,
            resample_displacement(kExec, ball.model, state, ball.ct.grid).samples)
      << "only here";
}

/// A side whose arrays may have so many bytes each.
struct FullSide {
  static inline std::size_t room = 0;
  template <class T>
  struct Array : CountedArray<T> {
    Array() = default;
    explicit Array(std::size_t count)
        : CountedArray<T>(count * sizeof(T) <= room ? count : 0), wanted(count) {}
    bool is_allocated() const { return wanted * sizeof(T) <= room; }
    std::size_t wanted = 0;
  };
  using Run = SeededRun<1>;
};

TEST(lattice_resample_loops, without_room_for_one_leave_it_to_the_cpu) {
  const CutBall ball({});
  FullSide::room = 1000000000;
  DeviceAllocator<FullSide> rooms;
  DeviceState state = ball.state;
  state.step_on(std::make_shared<DeviceBody<FullSide>>(ball.model, rooms));
  EXPECT_TRUE(state.step(kExec, ball.model, {}, 1e-3).finite);
  const Grid& grid = ball.ct.grid;
  const std::size_t voxels = sample_count(grid);
  const CtVolume ct = resample_ct(kExec, ball.model, state, ball.ct, grid).ct;
  const VectorVolume u = resample_displacement(kExec, ball.model, state, grid);
  const ScalarVolume ratio = resample_jacobian(kExec, ball.model, state, grid);
  for (const auto& [room, u_back, ratio_back, ct_back] :
       {std::tuple(100 * voxels, 12 * voxels, 4 * voxels, 2 * voxels),
        {8 * voxels, 0, 4 * voxels, 2 * voxels},
        {std::size_t(100), 0, 0, 0},
        {100 * voxels, 12 * voxels, 4 * voxels, 2 * voxels}}) {
    FullSide::room = room;
    const auto back_of = [&](const auto& make) {
      Bus::back = 0;
      make();
      return Bus::back - Bus::back % voxels;  // less what is told
    };
    std::vector<Vec3> u_now;
    std::vector<float> ratio_now;
    std::vector<std::int16_t> ct_now;
    EXPECT_EQ(back_of([&] { u_now = state.resample_displacement(kExec, ball.model, grid).samples; }), u_back);
    EXPECT_EQ(back_of([&] { ratio_now = state.resample_jacobian(kExec, ball.model, grid).samples; }),
              ratio_back);
    EXPECT_EQ(back_of([&] { ct_now = state.resample(kExec, ball.model, ball.ct, grid).ct.samples; }),
              ct_back);
    EXPECT_TRUE(u_back > 0 || u_now == u.samples);
    EXPECT_TRUE(ratio_back > 0 || ratio_now == ratio.samples);
    EXPECT_TRUE(ct_back > 0 || ct_now == ct.samples);
  }
}

TEST(lattice_resample_loops, make_sections_across_a_wound_that_are_one_voxel_thick) {
  const CutBall ball({}, TissueLaw::kSolid);
  const Vec3d top = point_at(ball.ct.grid, {16, 16, 27});
  for (int axis = 0; axis < 3; axis++) {
    Grid grid{.size = {90, 90, 90}, .spacing = {2.5e-4, 2.5e-4, 2.5e-4}, .origin = {}, .axes = {}};
    grid.origin = top - Vec3d{0.011, 0.011, 0.011};
    grid.origin[axis] = top[axis], grid.size[axis] = 1;
    expect_the_cpus_ct(ball.model, ball.state, ball.ct, grid, {});
  }
}

TEST(lattice_resample_loops, a_ct_that_somebody_holds_outlives_the_next_one) {
  const CtVolume ct = ball_ct(25, 9);
  const Model model = body_of(ct, {3, 3, 3});
  DeviceState state = waved(model, 0);
  state.step_on(put_on_host<SeededRun<1>>(model));
  EXPECT_TRUE(state.step(kExec, model, {}, 1e-3).finite);
  const auto first = state.resample_there(kExec, model, ct, ct.grid, kAlone);
  ASSERT_TRUE(first);
  std::vector<std::int16_t> before(ct.samples.size()), after = before;
  first->samples->get(before);
  for (int n = 0; n < 3; n++) EXPECT_TRUE(state.step(kExec, model, {.gravity = {0, 0, -9.81}}, 1e-2).finite);
  EXPECT_NE(state.resample(kExec, model, ct, ct.grid, kAlone).ct.samples, before) << "it moves";
  first->samples->get(after);
  EXPECT_EQ(after, before);
}

TEST(lattice_resample_loops, leave_a_body_without_stiffness_to_the_cpu) {
  CutBall ball({.method = Method::kPbd, .pbd_stiffness = 0});
  DeviceState state = ball.state;
  state.step_on(put_on_host<SeededRun<1>>(ball.model));
  EXPECT_TRUE(state.step(kExec, ball.model, {}, 1e-3).finite);
  const CtVolume now = state.resample(kExec, ball.model, ball.ct, ball.ct.grid).ct;
  EXPECT_EQ(now.samples, resample_ct(kExec, ball.model, state, ball.ct, ball.ct.grid).ct.samples);
  EXPECT_GT(std::count_if(now.samples.begin(), now.samples.end(), [](int hu) { return hu > -200; }), 5000);
}

TEST(lattice_resample_loops, of_a_wound_are_made_there_and_follow_the_blade) {
  CutBall ball({});
  DeviceState state = ball.state;
  state.step_on(put_on_host<SeededRun<1>>(ball.model));
  const Inputs inputs{.gravity = {0, 0, -9.81}};
  EXPECT_TRUE(state.step(kExec, ball.model, inputs, 1e-3).finite);
  for (int n = 0; n < 2; n++) {
    Bus::back = 0;
    const CtVolume now = state.resample(kExec, ball.model, ball.ct, ball.ct.grid, kAlone).ct;
    EXPECT_EQ(Bus::back, now.samples.size() * sizeof(std::int16_t) + kTold) << "and no state";
    const CtVolume here = resample_ct(kExec, ball.model, state, ball.ct, ball.ct.grid, kAlone).ct;
    EXPECT_LE(compared(now, here).other, 8) << "voxels: fused multiply-adds round otherwise";
    Bus::over = 0;
    (void)state.resample(kExec, ball.model, ball.ct, ball.ct.grid, kAlone);
    EXPECT_EQ(Bus::over, kTold) << "pieces are there";
    if (n > 0) break;
    EXPECT_GT(state.cut_edges(ball.model, ball.path({-6, -5, 0}, {6, -4, 0}, 10, 0), 0, 1, 1), 5);
    for (int k = 0; k < 3; k++) EXPECT_TRUE(state.step(kExec, ball.model, inputs, 2e-3).finite);
  }
}

}  // namespace
}  // namespace turgor::lattice

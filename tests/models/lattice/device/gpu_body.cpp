// What needs a GPU; elsewhere it is skipped with a sentence. What it does there, lattice_body_on tests here.
#include "turgor/models/lattice/device/gpu_body.hpp"

#include "tests/models/lattice/cut_ball.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/models/lattice/resample/resample.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;

/// Three steps, with a blade after the first one.
State end_of(const Gpu* gpu, Method method, TissueLaw law, bool coarse = false) {
  CutBlock block = cut_block(method, {13, 11, 9}, law == TissueLaw::kSprings, law);
  block.model.params.solver.coarse = coarse;
  DeviceState state = std::move(block.state);
  if (gpu != nullptr) state.step_on(put(*gpu, block.model).value());
  std::vector<NodeContact> contacts;
  if (method == Method::kVbd && !coarse) contacts = finger(block.model);
  const NodeLoad load{.slot = node_slot(block.model.lattice, 9, 6, 8), .force = {1e-3f, 0, 5e-3f}};
  const Inputs inputs{
      .gravity = {1, 0, -9.81}, .measure_residual = true, .loads = {&load, 1}, .contacts = contacts};
  for (int n = 0; n < 3; n++) {
    EXPECT_TRUE(state.step(kOne, block.model, inputs, kDt).finite);
    if (n > 0) continue;
    const BladePath path =
        lay_blade(block.model, state, {.from = {0.012, 0.016, 0.032}, .to = {0.03, 0.016, 0.032}}).value();
    EXPECT_GT(state.cut_edges(block.model, path, 0, 1, 1), 10);
  }
  return *state;
}

TEST(gpu_lattice, bodies_step_there_as_they_do_here) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  for (const auto& [method, law] : {std::pair(Method::kPbd, TissueLaw::kSprings),
                                    {Method::kVbd, TissueLaw::kSprings},
                                    {Method::kVbd, TissueLaw::kSolid}}) {
    const State here = end_of(nullptr, method, law), there = end_of(&*gpu, method, law);
    const Apart found =
        apart(cut_block(method, {13, 11, 9}, law == TissueLaw::kSprings, law).model, there, here);
    EXPECT_LT(found.most, 1e-4 * found.largest) << "m, method " << int(method) << ", law " << int(law);
    EXPECT_EQ(there.time, here.time);
  }
}

TEST(gpu_lattice, the_smooth_part_is_solved_for_there_as_it_is_here) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const State here = end_of(nullptr, Method::kVbd, TissueLaw::kSolid, true),
              there = end_of(&*gpu, Method::kVbd, TissueLaw::kSolid, true),
              alone = end_of(nullptr, Method::kVbd, TissueLaw::kSolid);
  const Model model = cut_block(Method::kVbd, {13, 11, 9}, false, TissueLaw::kSolid).model;
  const Apart found = apart(model, there, here);
  EXPECT_LT(found.most, 1e-4 * found.largest) << "m";
  EXPECT_GT(apart(model, here, alone).most, 0.01 * found.largest) << "m, by sweeps alone";
}

TEST(gpu_lattice, frames_as_graphs_have_the_bits_of_kernels_one_by_one) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const auto end = [&](Frames frames, TissueLaw law) {
    CutBlock block = cut_block(Method::kVbd, {13, 11, 9}, false, law);
    DeviceState state = std::move(block.state);
    state.step_on(put(*gpu, block.model, frames).value());
    for (int n = 0; n < 8; n++) {
      const NodeLoad load{.slot = node_slot(block.model.lattice, 9, 6, 8), .force = {1e-3f, 0, 5e-3f}};
      const Inputs inputs{
          .gravity = {n < 2 ? 0.0 : 1.0, 0, -9.81},  // and a load less, shorter steps, a blade
          .measure_residual = n > 6,
          .loads = {&load, std::size_t(n < 4)}};
      EXPECT_TRUE(state.step(kOne, block.model, inputs, n < 5 ? kDt : kDt / 2).finite);
      if (n != 3) continue;
      const BladePath path =
          lay_blade(block.model, state, {.from = {0.012, 0.016, 0.032}, .to = {0.03, 0.016, 0.032}}).value();
      EXPECT_GT(state.cut_edges(block.model, path, 0, 1, 1), 10);
    }
    return state_hash(block.model, state);
  };
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid})
    EXPECT_EQ(end(Frames::kAsGraphs, law), end(Frames::kOneByOne, law));
}

/// Of the same body, by both: how many voxels have other values.
long other_voxels(const Gpu& gpu, const Model& model, const State& state, const CtVolume& ct) {
  const std::shared_ptr<BodyBackend> body = put(gpu, model).value();
  body->put_state(model, state);
  CtVolume there = ct;
  body->resample(kOne, model, state, ct, ct.grid, {}).value().samples->get(there.samples);
  const CtVolume here = resample_ct(kOne, model, state, ct, ct.grid).ct;
  long other = 0;
  for (std::size_t v = 0; v < here.samples.size(); v++) other += there.samples[v] != here.samples[v];
  return other;
}

TEST(gpu_lattice, the_deformed_ct_made_there_is_the_one_made_here) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const CtVolume ct = ball_ct(33, 12.3);
  Model model = body_of(ct, {3, 5, 2});
  model.params.solver.ordering = Ordering::kColors;
  State state = make_state(model);
  move(model, state, [](Vec3d x) {
    return Vec3d{0.003 * std::sin(300 * x.y), 0.004 * std::sin(400 * x.x), 0};
  });
  EXPECT_LE(other_voxels(*gpu, model, state, ct), long(ct.samples.size()) / 1000)
      << "fused multiply-adds round otherwise";
}

TEST(gpu_lattice, the_deformed_ct_of_a_wound_made_there_is_the_one_made_here) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  for (CutBall& ball : std::vector{CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd})}) {
    EXPECT_LE(other_voxels(*gpu, ball.model, ball.state, ball.ct), long(ball.ct.samples.size()) / 1000);
    ASSERT_GT(cut_region(ball.model, ball.state, ball.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
    EXPECT_LE(other_voxels(*gpu, ball.model, ball.state, ball.ct), long(ball.ct.samples.size()) / 1000);
  }
}

TEST(gpu_lattice, the_fields_of_a_wound_made_there_are_those_made_here) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const CutBall ball({}, TissueLaw::kSolid);
  const Grid& grid = ball.ct.grid;
  const std::shared_ptr<BodyBackend> body = put(*gpu, ball.model).value();
  body->put_state(ball.model, ball.state);
  const VectorVolume u = resample_displacement(kOne, ball.model, ball.state, grid);
  const ScalarVolume ratio = resample_jacobian(kOne, ball.model, ball.state, grid);
  std::vector<Vec3> u_there(u.samples.size());
  std::vector<float> ratio_there(u.samples.size());
  ASSERT_TRUE(body->get_displacement(ball.model, ball.state, grid, u_there));
  ASSERT_TRUE(body->get_jacobian(ball.model, ball.state, grid, ratio_there));
  long other = 0;
  for (std::size_t v = 0; v < u_there.size(); v++)
    other += norm(u_there[v] - u.samples[v]) > 1e-7f || std::abs(ratio_there[v] - ratio.samples[v]) > 1e-5f;
  EXPECT_LE(other, long(u_there.size()) / 1000) << "fused multiply-adds round otherwise";
}

TEST(gpu_lattice, what_runs_there_is_known_before) {
  Params params;
  params.solver.ordering = Ordering::kColors;
  EXPECT_TRUE(runs_on_gpu(params));
  params.tissue.law = TissueLaw::kSolid;
  EXPECT_TRUE(runs_on_gpu(params)) << "its coarse space does too";
  params.solver.sleep = 1e-3;
  EXPECT_TRUE(runs_on_gpu(params)) << "rows may sleep, and need not";
  params.solver.method = Method::kPbd;
  EXPECT_TRUE(runs_on_gpu(params));
  params.solver.ordering = Ordering::kSlabs;
  EXPECT_FALSE(runs_on_gpu(params));
}

}  // namespace
}  // namespace turgor::lattice

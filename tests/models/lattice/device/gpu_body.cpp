// Tests that need a GPU; they are skipped without one. DeviceBody runs the same kernels on the host.
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
  if (gpu != nullptr) state.use_backend(upload_model(*gpu, block.model).value());
  std::vector<NodeContact> contacts;
  if (method == Method::kVbd && !coarse) contacts = finger(block.model);
  const NodeLoad load{.slot = node_slot(block.model.anatomy.lattice, 9, 6, 8), .force = {1e-3f, 0, 5e-3f}};
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

// Steps on the GPU match the CPU within rounding.
TEST(GpuLattice, StepsMatchCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  for (const auto& [method, law] : {std::pair(Method::kPbd, TissueLaw::kSprings),
                                    {Method::kVbd, TissueLaw::kSprings},
                                    {Method::kVbd, TissueLaw::kSolid}}) {
    const State host = end_of(nullptr, method, law), device = end_of(&*gpu, method, law);
    const StateDifference found =
        state_difference(cut_block(method, {13, 11, 9}, law == TissueLaw::kSprings, law).model, device, host);
    EXPECT_LT(found.most, 1e-4 * found.largest) << "m, method " << int(method) << ", law " << int(law);
    EXPECT_EQ(device.motion.time, host.motion.time);
  }
}

// The coarse correction on the GPU matches the CPU.
TEST(GpuLattice, CoarseCorrectionMatchesCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const State host = end_of(nullptr, Method::kVbd, TissueLaw::kSolid, true),
              device = end_of(&*gpu, Method::kVbd, TissueLaw::kSolid, true),
              alone = end_of(nullptr, Method::kVbd, TissueLaw::kSolid);
  const Model model = cut_block(Method::kVbd, {13, 11, 9}, false, TissueLaw::kSolid).model;
  const StateDifference found = state_difference(model, device, host);
  EXPECT_LT(found.most, 1e-4 * found.largest) << "m";
  EXPECT_GT(state_difference(model, host, alone).most, 0.01 * found.largest) << "m, by sweeps alone";
}

// Frames as CUDA graphs have the bits of single kernel launches.
TEST(GpuLattice, GraphsMatchSingleKernels) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const auto end = [&](Frames frames, TissueLaw law) {
    CutBlock block = cut_block(Method::kVbd, {13, 11, 9}, false, law);
    DeviceState state = std::move(block.state);
    state.use_backend(upload_model(*gpu, block.model, frames).value());
    for (int n = 0; n < 8; n++) {
      const NodeLoad load{.slot = node_slot(block.model.anatomy.lattice, 9, 6, 8),
                          .force = {1e-3f, 0, 5e-3f}};
      const Inputs inputs{
          .gravity = {n < 2 ? 0.0 : 1.0, 0, -9.81},  // changes: one load less, shorter steps, a blade
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

/// Number of voxels that differ between the deformed CTs of the GPU and the CPU.
long differing_voxels(const Gpu& gpu, const Model& model, const State& state, const CtVolume& ct) {
  const std::shared_ptr<BodyBackend> body = upload_model(gpu, model).value();
  body->upload_state(model, state);
  CtVolume device = ct;
  body->resample(kOne, model, state.cuts, ct, ct.grid, {}).value().samples->download(device.samples);
  const CtVolume host = resample_ct(kOne, model, state, ct, ct.grid).ct;
  long other = 0;
  for (std::size_t v = 0; v < host.samples.size(); v++) other += device.samples[v] != host.samples[v];
  return other;
}

// The deformed CT of the GPU matches that of the CPU.
TEST(GpuLattice, DeformedCtMatchesCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const CtVolume ct = ball_ct(33, 12.3);
  Model model = body_of(ct, {3, 5, 2});
  model.params.solver.ordering = Ordering::kColors;
  State state = make_state(model);
  move(model, state, [](Vec3d x) {
    return Vec3d{0.003 * std::sin(300 * x.y), 0.004 * std::sin(400 * x.x), 0};
  });
  EXPECT_LE(differing_voxels(*gpu, model, state, ct), long(ct.samples.size()) / 1000)
      << "fused multiply-adds round differently";
}

// The deformed CT of a wounded body on the GPU matches that of the CPU.
TEST(GpuLattice, DeformedCtOfWoundMatchesCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  for (CutBall& ball : std::vector{CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd})}) {
    EXPECT_LE(differing_voxels(*gpu, ball.model, ball.state, ball.ct), long(ball.ct.samples.size()) / 1000);
    ASSERT_GT(cut_region(ball.model, ball.state, ball.path({-6, -5, 0}, {6, -4, 0}, 0, 0.003)), 5);
    EXPECT_LE(differing_voxels(*gpu, ball.model, ball.state, ball.ct), long(ball.ct.samples.size()) / 1000);
  }
}

// Displacement and Jacobian fields of a wounded body on the GPU match those of the CPU.
TEST(GpuLattice, FieldsOfWoundMatchCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const CutBall ball({}, TissueLaw::kSolid);
  const Grid& grid = ball.ct.grid;
  const std::shared_ptr<BodyBackend> body = upload_model(*gpu, ball.model).value();
  body->upload_state(ball.model, ball.state);
  const VectorVolume u = resample_displacement(kOne, ball.model, ball.state, grid);
  const ScalarVolume ratio = resample_jacobian(kOne, ball.model, ball.state, grid);
  std::vector<Vec3> u_device(u.samples.size());
  std::vector<float> ratio_device(u.samples.size());
  ASSERT_TRUE(body->download_displacement(ball.model, ball.state.cuts, grid, u_device));
  ASSERT_TRUE(body->download_jacobian(ball.model, ball.state.cuts, grid, ratio_device));
  long other = 0;
  for (std::size_t v = 0; v < u_device.size(); v++)
    other += norm(u_device[v] - u.samples[v]) > 1e-7f || std::abs(ratio_device[v] - ratio.samples[v]) > 1e-5f;
  EXPECT_LE(other, long(u_device.size()) / 1000) << "fused multiply-adds round differently";
}

// runs_on_gpu reports which parameters the GPU supports.
TEST(GpuLattice, ReportsSupportedParameters) {
  Params params;
  params.solver.ordering = Ordering::kColors;
  EXPECT_TRUE(runs_on_gpu(params));
  params.tissue.law = TissueLaw::kSolid;
  EXPECT_TRUE(runs_on_gpu(params)) << "with its coarse space";
  params.solver.sleep_speed = 1e-3;
  EXPECT_TRUE(runs_on_gpu(params)) << "sleep is optional";
  params.solver.method = Method::kPbd;
  EXPECT_TRUE(runs_on_gpu(params));
  params.solver.ordering = Ordering::kSlabs;
  EXPECT_FALSE(runs_on_gpu(params));
}

}  // namespace
}  // namespace turgor::lattice

// Kernels and transfers of a frame on a GPU, as docs/gpu.md states them. Each costs microseconds on a real
// device.
#include "cuda_runtime.h"
#include "tests/models/cloth/sheets.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace turgor {
namespace {

struct FrameCost {
  long kernels = 0, downloads = 0;
  std::size_t uploaded = 0, downloaded = 0;
};
template <class Step>
FrameCost cost_of(const Step& step) {
  const PretendedCounts before = pretended_counts();
  step();
  const PretendedCounts now = pretended_counts();
  return {now.kernels - before.kernels, now.downloads - before.downloads, now.uploaded - before.uploaded,
          now.downloaded - before.downloaded};
}

}  // namespace
}  // namespace turgor

namespace turgor::lattice {
namespace {

// A lattice frame launches the number of kernels and downloads that the frame bench predicts.
TEST(PretendedGpuFrames, LatticeFrame_KernelCount) {
  struct Kind {
    Method method;
    TissueLaw law;
    long most;  // largest number of kernels; colors without skin need none
  };
  for (const Kind kind : {Kind{Method::kPbd, TissueLaw::kSprings, 82},
                          {Method::kVbd, TissueLaw::kSprings, 82},
                          {Method::kVbd, TissueLaw::kSolid, 171}}) {
    CutBlock block = cut_block(kind.method, {30, 20, 16}, kind.law == TissueLaw::kSprings, kind.law);
    ASSERT_EQ(block.model.params.solver.sweeps, 5);
    DeviceState state = std::move(block.state);
    state.use_backend(upload_model(open_gpu().value(), block.model).value());
    FrameCost cost;
    for (int frame = 0; frame < 4; frame++)
      cost = cost_of([&] { state.step(Exec(1), block.model, {.gravity = {0, 0, -9.81}}, 1.0 / 60); });
    EXPECT_LE(cost.kernels, kind.most);
    EXPECT_GE(cost.kernels, kind.method == Method::kPbd ? 42 : kind.most);
    EXPECT_EQ(cost.downloads, 1);
    EXPECT_EQ(cost.uploaded + cost.downloaded, 16u) << "bytes";
  }
}

}  // namespace
}  // namespace turgor::lattice

namespace turgor::cloth {
namespace {

Model sheet(int side, bool self) {
  Params params;
  params.solver = {.method = Method::kChebyshev, .sweeps = 8};
  params.collision.self = self, params.collision.thickness = 0.0096;
  return must_build(flat_sheet(side), params);
}

FrameCost cost_of(const Model& model, DeviceState& state, const Inputs& inputs) {
  return turgor::cost_of([&] {
    const StepReport report = state.step(Exec(1), model, inputs, kFrame);
    EXPECT_EQ(report.in_impact_zone, 0) << "a frame with impact zones returns to the host";
  });
}

// A flag frame launches the number of kernels and downloads that docs/gpu.md states.
TEST(PretendedGpuFrames, FlagFrame_KernelCount) {
  const Result<Gpu> gpu = open_gpu();
  for (const int side : {40, 80})
    for (const bool self : {false, true}) {
      const Model model = sheet(side, self);
      DeviceState state = make_state(model);
      for (int j = 0; j < side; j++) EXPECT_TRUE(state.hold(model, j * side));
      state.use_backend(put(*gpu, model).value());
      Inputs inputs{.gravity = {0, 0, -9.81}};
      inputs.air = {.velocity = {6, 0, 2}, .gusts = 0.3};
      FrameCost cost;
      for (int frame = 0; frame < 6; frame++) cost = cost_of(model, state, inputs);
      EXPECT_GE(cost.kernels, self ? 50 : 20) << side;
      EXPECT_LE(cost.kernels, self ? 55 : 20) << side;
      EXPECT_EQ(cost.downloads, self ? 4 : 1) << side;
      EXPECT_LE(cost.uploaded, std::size_t(16 * side + 30)) << "bytes: held vertices and zeroed counters";
      EXPECT_LE(cost.downloaded, 20u) << "bytes";
    }
}

// A frame of crumpled cloth launches the number of kernels and downloads that docs/gpu.md states.
TEST(PretendedGpuFrames, CrumpledClothFrame_KernelCount) {
  const Model model = sheet(30, true);
  DeviceState state = make_state(model);
  shake(model, state.change().v, 4);
  state.use_backend(put(open_gpu().value(), model).value());
  (void)cost_of(model, state, {});
  for (int frame = 0; frame < 6; frame++) {
    const FrameCost cost = cost_of(model, state, {.gravity = {0, 0, -9.81}});
    EXPECT_EQ(cost.kernels, 110);
    EXPECT_EQ(cost.downloads, 5);
    EXPECT_LE(cost.uploaded + cost.downloaded, 200u) << "bytes";
  }
}

}  // namespace
}  // namespace turgor::cloth

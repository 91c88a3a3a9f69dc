// What a frame asks of a GPU and waits for, as docs/gpu.md has it: each costs microseconds there.
#include "cuda_runtime.h"
#include "tests/models/cloth/sheets.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace turgor {
namespace {

struct Asked {
  long kernels = 0, answers = 0;
  std::size_t over = 0, back = 0;
};
template <class Step>
Asked asked_by(const Step& step) {
  const PretendedCounts before = pretended_counts();
  step();
  const PretendedCounts now = pretended_counts();
  return {now.kernels - before.kernels, now.downloads - before.downloads, now.over - before.over,
          now.back - before.back};
}

}  // namespace
}  // namespace turgor

namespace turgor::lattice {
namespace {

TEST(PretendedGpu, a_frame_of_a_lattice_asks_as_often_as_the_bench_of_frames_predicts) {
  struct Kind {
    Method method;
    TissueLaw law;
    long most;  // kernels; colours without skin need none
  };
  for (const Kind kind : {Kind{Method::kPbd, TissueLaw::kSprings, 82},
                          {Method::kVbd, TissueLaw::kSprings, 42},
                          {Method::kVbd, TissueLaw::kSolid, 127}}) {
    CutBlock block = cut_block(kind.method, {30, 20, 16}, kind.law == TissueLaw::kSprings, kind.law);
    ASSERT_EQ(block.model.params.solver.sweeps, 5);
    DeviceState state = std::move(block.state);
    state.step_on(put(open_gpu().value(), block.model).value());
    Asked asked;
    for (int frame = 0; frame < 4; frame++)
      asked = asked_by([&] { state.step(Exec(1), block.model, {.gravity = {0, 0, -9.81}}, 1.0 / 60); });
    EXPECT_LE(asked.kernels, kind.most);
    EXPECT_GE(asked.kernels, kind.method == Method::kPbd ? 42 : kind.most);
    EXPECT_EQ(asked.answers, 1);
    EXPECT_EQ(asked.over + asked.back, 16u) << "bytes";
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

Asked asked_by(const Model& model, DeviceState& state, const Inputs& inputs) {
  return turgor::asked_by([&] {
    const StepReport report = state.step(Exec(1), model, inputs, kFrame);
    EXPECT_EQ(report.in_impact_zone, 0) << "a frame in which anything is caught comes back";
  });
}

TEST(PretendedGpu, a_frame_of_a_flag_asks_as_often_as_the_documents_say) {
  const Result<Gpu> gpu = open_gpu();
  for (const int side : {40, 80})
    for (const bool self : {false, true}) {
      const Model model = sheet(side, self);
      DeviceState state = make_state(model);
      for (int j = 0; j < side; j++) EXPECT_TRUE(state.hold(model, j * side));
      state.step_on(put(*gpu, model).value());
      Inputs inputs{.gravity = {0, 0, -9.81}};
      inputs.air = {.velocity = {6, 0, 2}, .gusts = 0.3};
      Asked asked;
      for (int frame = 0; frame < 6; frame++) asked = asked_by(model, state, inputs);
      EXPECT_GE(asked.kernels, self ? 50 : 20) << side;
      EXPECT_LE(asked.kernels, self ? 55 : 20) << side;
      EXPECT_EQ(asked.answers, self ? 4 : 1) << side;
      EXPECT_LE(asked.over, std::size_t(16 * side + 30)) << "bytes: what is held, and clean answers";
      EXPECT_LE(asked.back, 20u) << "bytes";
    }
}

TEST(PretendedGpu, a_frame_of_crumpled_cloth_asks_as_often_as_the_documents_say) {
  const Model model = sheet(30, true);
  DeviceState state = make_state(model);
  shake(model, state.change().v, 4);
  state.step_on(put(open_gpu().value(), model).value());
  (void)asked_by(model, state, {});
  for (int frame = 0; frame < 6; frame++) {
    const Asked asked = asked_by(model, state, {.gravity = {0, 0, -9.81}});
    EXPECT_EQ(asked.kernels, 110);
    EXPECT_EQ(asked.answers, 5);
    EXPECT_LE(asked.over + asked.back, 200u) << "bytes";
  }
}

}  // namespace
}  // namespace turgor::cloth

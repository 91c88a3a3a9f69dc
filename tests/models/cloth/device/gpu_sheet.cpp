// Tests that need a GPU; they are skipped without one. ClothDeviceSheet runs the same kernels on the host.
#include "turgor/models/cloth/device/gpu_sheet.hpp"

#include "tests/models/cloth/sheets.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"

namespace turgor::cloth {
namespace {

State end_of(const Gpu* gpu, const Model& model) {
  const contact::Shape rod = contact::Capsule{0.03, 0.05};
  DeviceState state = make_state(model);
  for (int v = 0; v < 5; v++) EXPECT_TRUE(state.hold(model, v));
  if (gpu != nullptr) state.use_backend(put(*gpu, model).value());
  Inputs inputs{.gravity = {0, 0, -9.81}, .measure_residual = true};
  inputs.air.velocity = {4, 2, 1};
  inputs.air.gusts = 0.3;
  const TriMesh table = make_sheet({{-0.5, -0.5, -0.003}, {1, 0, 0}, {0, 1, 0}, 3, 3});
  inputs.obstacles = {
      plane_obstacle({0, 0, -0.004}, {0.05, 0, 1}), surface_obstacle(moving_surface(table, {}, 0)),
      contact::cloth_tool(rod, {.position = {0.1, 0.1, -0.034}}, {.position = {0.1, 0.1, -0.032}}, kFrame)};
  for (int n = 0; n < 2; n++) EXPECT_TRUE(state.step(Exec(1), model, inputs, kFrame).finite);
  return *state;
}

// Steps of sheets on the GPU match the CPU within rounding.
TEST(GpuCloth, StepsMatchCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  for (const Law law : {Law::kSprings, Law::kSheet})
    for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2}) {
      Params params{.fabric = {.law = law}, .solver = {.integrator = integrator, .strain_limit = 0.05}};
      params.collision.thickness = integrator == Integrator::kEuler ? 0.0096 : 0.005;
      const Model model = must_build(flat_sheet(20), params);
      const State host = end_of(nullptr, model), device = end_of(&*gpu, model);
      double displacement = 0, difference = 0;
      for (std::size_t v = 0; v < std::size_t(model.count); v++) {
        displacement = std::max(displacement, double(norm(host.x[v] - model.x_rest[v])));
        difference = std::max(difference, double(norm(host.x[v] - device.x[v])));
      }
      EXPECT_LT(difference, 1e-2 * displacement) << "rounding error, m, law " << int(law);
      EXPECT_EQ(device.time, host.time);
    }
}

}  // namespace
}  // namespace turgor::cloth

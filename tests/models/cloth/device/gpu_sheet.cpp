// Tests that need a GPU; they are skipped without one. ClothDeviceSheet runs the same kernels on the host.
#include "turgor/models/cloth/device/gpu_sheet.hpp"

#include <algorithm>
#include <cmath>

#include "tests/models/cloth/sheets.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"

namespace turgor::cloth {
namespace {

/// Two frames of a wavy sheet that is held at an edge and falls on a plane, a table and a rising rod, which
/// begin just out of contact. (Sheets that begin in contact are pushed out by impact zones, which depend on
/// rounding: shifts of 1e-9 m then grow to a third of the displacement.) `shift`: of the vertices [m].
State end_of(const Gpu* gpu, const Model& model, Real shift = 0) {
  State start = make_state(model);
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    const Vec3 x = start.x[v];
    start.x.set(
        v, {x.x, x.y, x.z + Real(2e-4) * (1 + std::sin(31 * x.x + 17 * x.y)) + (v % 2 ? shift : -shift)});
  }
  DeviceState state = start;
  for (int v = 0; v < 5; v++) EXPECT_TRUE(state.hold(model, v));
  if (gpu != nullptr) state.use_backend(put(*gpu, model).value());
  Inputs inputs{.gravity = {0, 0, -9.81}, .measure_residual = true};
  inputs.air.velocity = {1, 0.5, -1};
  inputs.air.gusts = 0.3;
  const double low = -model.params.collision.thickness - 5e-4, radius = 0.03;
  const TriMesh table = make_sheet({{-0.5, -0.5, Real(low)}, {1, 0, 0}, {0, 1, 0}, 3, 3});
  const contact::Shape rod = contact::Capsule{radius, 0.05};
  const contact::Pose pose{.position = {0.1, 0.1, low - radius}},
      end{.position = {0.1, 0.1, low - radius + 1e-3}};
  inputs.obstacles = {plane_obstacle({0, 0, Real(low)}, {0.05, 0, 1}),
                      surface_obstacle(moving_surface(table, {}, 0)),
                      contact::cloth_tool(rod, pose, end, kFrame)};
  for (int n = 0; n < 2; n++) {
    const StepReport report = state.step(Exec(1), model, inputs, kFrame);
    EXPECT_TRUE(report.finite);
    EXPECT_GT(report.contacts, 20);
  }
  return *state;
}
double largest_difference(const Model& model, const Vectors& a, const Vectors& b) {
  double largest = 0;
  for (std::size_t v = 0; v < std::size_t(model.count); v++)
    largest = std::max(largest, double(norm(a[v] - b[v])));
  return largest;
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
      const double tolerance = 1e-2 * largest_difference(model, host.x, model.x_rest);
      EXPECT_LT(largest_difference(model, host.x, device.x), tolerance)
          << "m, law " << int(law) << ", integrator " << int(integrator);
      EXPECT_LT(largest_difference(model, host.x, end_of(nullptr, model, Real(1e-8)).x), tolerance)
          << "m, the scene itself is sensitive to rounding";
      EXPECT_EQ(device.time, host.time);
    }
}

}  // namespace
}  // namespace turgor::cloth

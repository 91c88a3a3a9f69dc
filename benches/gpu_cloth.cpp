// Frames of cloth on a GPU: flags in gusts, and the falling stack of Offset Geometric Contact [Chen et al.
// 2025: 246 000 vertices, 210 ms a frame on a CPU, 6.3 ms on a GPU]. The state stays on the GPU. Prints one
// line of JSON each. `bench_gpu_cloth NAME` runs only the bodies whose names begin with NAME.
#include <cstdio>
#include <string_view>

#include "tests/models/cloth/stack.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"

namespace {

using namespace turgor;
using namespace turgor::cloth;

/// Times of frames [ms].
struct Times {
  double median = 0, mean = 0, largest = 0;
  StepReport last;
  int in_impact_zones = 0;  // vertices, all frames
};

Times frame_times(const Gpu& gpu, const Exec& exec, const Model& model, const State& state,
                  const Inputs& inputs, int warm, int frames) {
  const auto backend = put(gpu, model);
  if (!backend)
    return std::fprintf(stderr, "bench_gpu_cloth: %s\n", backend.error().message.c_str()), Times{};
  DeviceState on_gpu = state;
  on_gpu.use_backend(*backend);
  for (int n = 0; n < warm; n++) on_gpu.step(exec, model, inputs, kFrame);
  Times times;
  std::vector<double> ms;
  for (int n = 0; n < frames; n++) {
    const Timer timer;
    times.last = on_gpu.step(exec, model, inputs, kFrame);
    ms.push_back(1e3 * timer.seconds());
    times.mean += ms.back() / frames, times.largest = std::max(times.largest, ms.back());
    times.in_impact_zones += times.last.in_impact_zone;
  }
  times.median = median(ms);
  return times;
}

void print(const std::string& name, const Model& model, const Times& t) {
  std::printf(R"({"body": "%s", "vertices": %d, )", name.c_str(), model.count);
  std::printf(R"("median_ms": %.4g, "mean_ms": %.4g, "largest_ms": %.4g, )", t.median, t.mean, t.largest);
  std::printf(R"("contacts": %d, "contact_iterations": %d, )", t.last.contacts, t.last.contact_iterations);
  std::printf(R"("in_impact_zones": %d, "finite": %s})", t.in_impact_zones, t.last.finite ? "true" : "false");
  std::puts("");
  std::fflush(stdout);
}

/// A square sheet in gusts, held along its first column.
void flag(const Gpu& gpu, const Exec& exec, const std::string& name, int side, bool self) {
  constexpr double kSpacing = 0.01;
  const double length = kSpacing * (side - 1);
  Params params;
  params.solver = {.method = Method::kChebyshev, .sweeps = 8};
  params.collision = {.self = self, .thickness = 0.96 * kSpacing};
  const Model model = must_build(
      make_sheet({.side = {length, 0, 0}, .up = {0, length, 0}, .columns = side - 1, .rows = side - 1}),
      params);
  State state = make_state(model);
  for (int j = 0; j < side; j++) (void)hold(model, state, j * side);
  Inputs inputs{.gravity = {0, 0, -9.81}};
  inputs.air.velocity = {6, 0, 2};
  inputs.air.gusts = 0.3;
  print(name, model, frame_times(gpu, exec, model, state, inputs, 30, 31));
}

/// A second of 50 layers that fall on a table and on each other.
void stack(const Gpu& gpu, const Exec& exec, const std::string& name, int side) {
  const Stack stack = make_stack(50, side, 2 * kStackThickness, Method::kChebyshev);
  print(name, stack.model, frame_times(gpu, exec, stack.model, stack.state, stack.inputs, 0, 60));
}

}  // namespace

int main(int count, char** arguments) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) return std::fprintf(stderr, "bench_gpu_cloth: %s\n", gpu.error().message.c_str()), 2;
  const Exec exec;
  const std::string_view only = count > 1 ? arguments[1] : "";
  const auto wanted = [&](const std::string& name) { return name.starts_with(only); };
  for (const int side : {316, 1000})
    for (const bool self : {false, true})
      if (const std::string name = "flag " + std::to_string(side * side) + (self ? " self" : "");
          wanted(name))
        flag(*gpu, exec, name, side, self);
  for (const int side : {25, 50, 70})
    if (const std::string name = "stack " + std::to_string(50 * side * side); wanted(name))
      stack(*gpu, exec, name, side);
}

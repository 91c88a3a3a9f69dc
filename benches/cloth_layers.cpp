// Layers of cloth on a table: one, two and four sheets at rest, and a stack of 50 sheets that falls, as in
// the largest scene of Offset Geometric Contact [Chen et al. 2025: 246 000 vertices, 475 000 triangles, 210
// ms a frame on average and 550 ms at most, on a CPU]. Triangles that intersect at the end are an error.
#include <chrono>

#include <benchmark/benchmark.h>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"

namespace turgor::cloth {
namespace {

constexpr double kCell = 0.01, kThickness = 0.004;  // [m]

/// Horizontal sheets above each other, of side × side vertices, each turned a little and shifted, so that
/// their meshes are not aligned. `gap` is their distance at the start [m].
struct Stack {
  Model model;
  State state;
  Inputs inputs = in_vacuum();
};
Stack make_stack(int layers, int side, double gap, Method method) {
  constexpr Pattern kMeshes[] = {Pattern::kAlternating, Pattern::kRandom, Pattern::kDiagonal};
  const double length = kCell * (side - 1);
  TriMesh mesh;
  for (int layer = 0; layer < layers; layer++) {
    const TriMesh sheet = rectangle(kMeshes[layer % 3], 0, length, length, kCell);
    const int first = int(mesh.vertices.size());
    // at rest the sheets are far apart, so that they count as layers
    for (const Vec3 x : sheet.vertices) mesh.vertices.push_back(x + Vec3{0, 0, Real(0.1 * layer)});
    for (const Int3 t : sheet.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  }
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = method}};
  if (method == Method::kTwoLevel) params.solver.sweeps = 200;
  params.collision.thickness = kThickness;
  Stack stack{.model = must_build(mesh, params), .state = {}};
  stack.state = make_state(stack.model);
  for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
    const int layer = int(v) / (side * side);
    const double angle = 0.05 * layer, c = std::cos(angle), s = std::sin(angle);
    const Vec3d x(mesh.vertices[v]), from_center = x - Vec3d{length / 2, length / 2, x.z};
    const Vec3d turned{c * from_center.x - s * from_center.y, s * from_center.x + c * from_center.y,
                       kThickness / 2 + gap * layer};
    stack.state.x.set(std::size_t(stack.model.model_vertex[v]), Vec3(turned));
  }
  stack.inputs.obstacles.push_back(plane_obstacle({0, 0, 0}, {0, 0, 1}));
  return stack;
}

/// Times of frames [ms], and contacts of the last one.
struct Times {
  double sum = 0, largest = 0;
  int frames = 0, contacts = 0, iterations = 0;
};
void run_frames(const Exec& exec, Stack& stack, int frames, Times& times) {
  for (int n = 0; n < frames; n++) {
    const auto start = std::chrono::steady_clock::now();
    const StepReport report = step(exec, stack.model, stack.state, stack.inputs, kFrame);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    times.sum += ms, times.largest = std::max(times.largest, ms), times.frames++;
    times.contacts = report.contacts, times.iterations += report.iterations;
  }
}

void report(benchmark::State& bench, const Exec& exec, const Stack& stack, const Times& times) {
  const SelfDistance distance = self_distance(exec, stack.model, stack.state);
  bench.counters["vertices"] = stack.model.count;
  bench.counters["ms/frame"] = times.sum / times.frames;
  bench.counters["ms_most"] = times.largest;
  bench.counters["contacts"] = times.contacts;
  bench.counters["iterations"] = double(times.iterations) / times.frames;
  bench.counters["crossings"] = distance.crossings;
  if (distance.crossings > 0) bench.SkipWithError("layers cross each other");
}

/// Frames of layers at rest on a table.
void layers_at_rest(benchmark::State& bench) {
  const Exec exec(1);
  Stack stack = make_stack(int(bench.range(0)), 40, kThickness,
                           bench.range(1) ? Method::kTwoLevel : Method::kChebyshev);
  Times settle, times;
  run_frames(exec, stack, 30, settle);
  for (auto _ : bench) run_frames(exec, stack, 1, times);
  report(bench, exec, stack, times);
}
BENCHMARK(layers_at_rest)
    ->ArgsProduct({{1, 2, 4}, {0, 1}})
    ->ArgNames({"layers", "two_level"})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(20);

/// A second of 50 layers that fall on a table and on each other, two thicknesses apart. The number of
/// vertices doubles from each row to the next; the last has that of the paper.
void falling_stack(benchmark::State& bench) {
  const Exec exec(int(bench.range(2)));
  Stack stack = make_stack(50, int(bench.range(0)), 2 * kThickness,
                           bench.range(1) ? Method::kTwoLevel : Method::kChebyshev);
  Times times;
  for (auto _ : bench) run_frames(exec, stack, 60, times);
  report(bench, exec, stack, times);
}
BENCHMARK(falling_stack)
    ->ArgsProduct({{12, 17, 25, 35, 50, 70}, {0, 1}, {2}})
    ->ArgNames({"side", "two_level", "threads"})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->UseRealTime();

}  // namespace
}  // namespace turgor::cloth

BENCHMARK_MAIN();

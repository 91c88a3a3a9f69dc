// Layers of cloth on a table: one, two and four sheets at rest, and a stack of 50 sheets that falls, as in
// the largest scene of Offset Geometric Contact [Chen et al. 2025: 246 000 vertices, 475 000 triangles, 210
// ms a frame on average and 550 ms at most, on a CPU]. Triangles that intersect at the end are an error.
#include <chrono>

#include <benchmark/benchmark.h>

#include "tests/models/cloth/stack.hpp"

namespace turgor::cloth {
namespace {

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
  Stack stack = make_stack(int(bench.range(0)), 40, kStackThickness,
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
  Stack stack = make_stack(50, int(bench.range(0)), 2 * kStackThickness,
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

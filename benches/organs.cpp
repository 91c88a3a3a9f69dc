// Frames of organs that hold on to each other and touch, with all ticks of their tools: liver, gall bladder
// and stomach of scenes/abdomen.toml while the liver is lifted, on two threads. `of_clock` is the
// processor time of a frame over its length; `heaviest_ms` and `slowest_ms` are the most processor and wall
// time of a frame.
#include <algorithm>
#include <chrono>
#include <ctime>

#include <benchmark/benchmark.h>

#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

void abdomen_frame(benchmark::State& bench) {
  constexpr int kLifted = 36;  // frames until the organs have begun to move
  const Exec exec(2);
  const Result<Scene> scene = read_scene(TURGOR_SCENE_FOLDER "/abdomen.toml");
  if (!scene) return bench.SkipWithError(scene.error().message.c_str());
  Result<World> world = load_world(exec, *scene);
  if (!world) return bench.SkipWithError(world.error().message.c_str());
  for (int n = 0; n < kLifted; n++)
    if (!step(exec, *world)) return bench.SkipWithError("a frame failed");
  using Clock = std::chrono::steady_clock;
  double springs = 0, sites = 0, heaviest = 0, slowest = 0;
  const std::clock_t before = std::clock();
  for (auto _ : bench) {
    const std::clock_t begin = std::clock();
    const Clock::time_point began = Clock::now();
    if (!step(exec, *world)) return bench.SkipWithError("a frame failed");
    heaviest = std::max(heaviest, 1e3 * double(std::clock() - begin) / CLOCKS_PER_SEC);
    slowest = std::max(slowest, std::chrono::duration<double, std::milli>(Clock::now() - began).count());
    for (const Attachment& a : world->coupling.attachments) springs += double(a.ties.size());
    for (const BodyContact& c : world->coupling.contacts) sites += double(c.sites.size());
  }
  const double seconds = double(std::clock() - before) / CLOCKS_PER_SEC, frames = double(bench.iterations());
  bench.counters["of_clock"] = seconds / (frames * world->dt);
  bench.counters["heaviest_ms"] = heaviest, bench.counters["slowest_ms"] = slowest;
  bench.counters["springs"] = springs / frames;
  bench.counters["sites"] = sites / frames;
  bench.counters["unsolved"] = world->coupling.unsolved;
}
BENCHMARK(abdomen_frame)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->Iterations(60);

}  // namespace
}  // namespace turgor

BENCHMARK_MAIN();

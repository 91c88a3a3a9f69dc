// Frames of organs that hold on to each other and touch, with all ticks of their tools: liver, gall bladder
// and stomach of scenes/abdomen.toml while the gall bladder is lifted, on two threads. `of_clock` is the
// processor time of a frame over its length.
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
  double springs = 0, sites = 0;
  const std::clock_t before = std::clock();
  for (auto _ : bench) {
    if (!step(exec, *world)) return bench.SkipWithError("a frame failed");
    for (const Attachment& a : world->coupling.attachments) springs += double(a.ties.size());
    for (const BodyContact& c : world->coupling.contacts) sites += double(c.sites.size());
  }
  const double seconds = double(std::clock() - before) / CLOCKS_PER_SEC, frames = double(bench.iterations());
  bench.counters["of_clock"] = seconds / (frames * world->dt);
  bench.counters["springs"] = springs / frames;
  bench.counters["sites"] = sites / frames;
  bench.counters["unsolved"] = world->coupling.unsolved;
}
BENCHMARK(abdomen_frame)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->Iterations(60);

}  // namespace
}  // namespace turgor

BENCHMARK_MAIN();

// Frames of the stitched wound of scenes/suture.toml, 183 914 nodes: whole and partial cells in one run,
// frame by frame in turn, so that other work of the machine slows both. Of each phase: mean and most wall
// time of a frame, mean processor time of all threads, and share of the rows that are awake.
#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/model/rows.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

struct PhaseTimes {
  int frames = 0;
  double wall = 0, most = 0, cpu = 0;  // [s]
  double awake = 0;                    // rows, sum over frames
};

constexpr const char* kCells[] = {"whole", "partial"};
constexpr const char* kPhases[] = {"open", "pull", "rest"};

/// Phase of a frame: the wound opens, the stitches are pulled, and come to rest. −1: before the cut.
int phase_at(const World& world, const SutureScene& suture) {
  const double time = time_of(world);
  if (world.cuts[0].edges == 0) return -1;
  return time < suture.pull.start ? 0 : time < suture.pull.start + suture.pull.duration ? 1 : 2;
}

void time_frame(const Exec& exec, World& world, PhaseTimes& phase) {
  const std::clock_t begin = std::clock();
  const Timer timer;
  benchmark::DoNotOptimize(step(exec, world).value().seconds);
  const double seconds = timer.seconds();
  phase.frames++, phase.wall += seconds, phase.most = std::max(phase.most, seconds);
  phase.cpu += double(std::clock() - begin) / CLOCKS_PER_SEC;
  const std::vector<std::uint8_t>& awake = world.lattice_bodies[0].state->sleep.awake;
  phase.awake += double(std::count_if(awake.begin(), awake.end(), [](std::uint8_t is) { return is != 0; }));
}

void suture_frames(benchmark::State& bench) {
  const Exec exec(int(bench.range(0)));
  const auto file = std::filesystem::path(TURGOR_SCENE_FOLDER) / "suture.toml";
  for (auto _ : bench) {
    std::vector<World> worlds;
    double duration = 0;
    for (const char* partial : {"false", "true"}) {
      const Result<Scene> scene =
          read_scene(file, {std::string("body.torso.tissue.partial_cells=") + partial});
      if (!scene) return bench.SkipWithError(scene.error().message.c_str());
      Result<World> world = load_world(exec, *scene);
      if (!world) return bench.SkipWithError(world.error().message.c_str());
      worlds.push_back(std::move(*world)), duration = scene->duration;
    }
    std::array<std::array<PhaseTimes, 3>, 2> times;
    double wall = 0;
    while (time_of(worlds[0]) < duration)
      for (std::size_t w : {0u, 1u}) {
        PhaseTimes before;
        const int phase = phase_at(worlds[w], worlds[w].sutures[0].scene);
        PhaseTimes& now = phase < 0 ? before : times[w][std::size_t(phase)];
        const double earlier = now.wall;
        time_frame(exec, worlds[w], now);
        wall += now.wall - earlier;
      }
    bench.SetIterationTime(wall);
    bench.counters["nodes"] = worlds[1].lattice_bodies[0].model.anatomy.body_nodes;
    for (std::size_t w : {0u, 1u})
      for (std::size_t p : {0u, 1u, 2u}) {
        const PhaseTimes& t = times[w][p];
        const std::string name = std::string(kPhases[p]) + "_" + kCells[w];
        bench.counters[name + "_ms"] = 1e3 * t.wall / t.frames;
        bench.counters[name + "_most_ms"] = 1e3 * t.most;
        bench.counters[name + "_cpu_ms"] = 1e3 * t.cpu / t.frames;
        bench.counters[name + "_rows"] = t.awake / t.frames;
      }
  }
}
BENCHMARK(suture_frames)
    ->Arg(2)
    ->ArgName("threads")
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace turgor

BENCHMARK_MAIN();

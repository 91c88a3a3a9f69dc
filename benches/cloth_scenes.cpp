// Frames of shipped cloth scenes with the default law and solver, and with springs and 8 sweeps. Both run in
// turn, frame by frame, on one thread: `of_sweeps` is the ratio of their processor times. The goal is 1.5.
#include <algorithm>
#include <array>
#include <ctime>
#include <vector>

#include <benchmark/benchmark.h>

#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

/// Processor time of this thread [ms].
double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

/// Settings of a body that replace the default law and solver.
std::vector<std::string> springs_and_sweeps(const std::string& body) {
  return {body + ".fabric.law=springs", body + ".solver.method=sweeps", body + ".solver.sweeps=8"};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// All frames of a scene, once with the defaults and once with sweeps.
void frames(benchmark::State& bench, const std::string& file, const std::string& body) {
  const Exec exec(1);
  std::vector<World> worlds;
  int count = 0;
  for (const std::vector<std::string>& settings : {std::vector<std::string>(), springs_and_sweeps(body)}) {
    const Result<Scene> scene = read_scene(TURGOR_SCENE_FOLDER + file, settings);
    if (!scene) return bench.SkipWithError(scene.error().message.c_str());
    Result<World> world = load_world(exec, *scene);
    if (!world) return bench.SkipWithError(world.error().message.c_str());
    worlds.push_back(std::move(*world));
    count = int(scene->duration * scene->frame_rate);
  }
  std::array<std::vector<double>, 2> times;
  std::array<double, 2> sums{};
  int iterations = 0, contacts = 0;
  for (auto _ : bench)
    for (int n = 0; n < count; n++)
      for (std::size_t w = 0; w < 2; w++) {
        const double begin = thread_time();
        if (!step(exec, worlds[w])) return bench.SkipWithError("a frame failed");
        times[w].push_back(thread_time() - begin);
        sums[w] += times[w].back();
        const ClothSample& sample = worlds[w].cloth_bodies[0].samples.back();
        if (w == 0) iterations += sample.iterations, contacts += sample.contacts;
      }
  bench.counters["ms"] = median(times[0]), bench.counters["sweeps_ms"] = median(times[1]);
  bench.counters["of_sweeps"] = sums[0] / sums[1];
  bench.counters["of_sweeps_median"] = median(times[0]) / median(times[1]);
  bench.counters["iterations"] = double(iterations) / count;
  bench.counters["contacts"] = double(contacts) / count;
}
void flag(benchmark::State& bench) { frames(bench, "/flag.toml", "body.flag"); }
void tshirt(benchmark::State& bench) { frames(bench, "/tshirt.toml", "body.shirt"); }
BENCHMARK(flag)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(tshirt)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace turgor

BENCHMARK_MAIN();

// Start of 64 worlds whose Green's functions are cached, in turn and in 64 threads: what a vector environment
// does at every start. More than twice the time in threads is an error.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>

#include "turgor/sim/world.hpp"

namespace {

using namespace turgor;
namespace fs = std::filesystem;

constexpr int kWorlds = 64;
constexpr double kMostRatio = 2;  // time in threads over that in turn

/// A scene whose cache lies in a folder of its own and is filled.
struct WarmScene {
  fs::path folder;
  Scene scene;

  WarmScene() {
    std::string name = (fs::temp_directory_path() / "turgor-bench-XXXXXX").string();
    folder = mkdtemp(name.data());
    scene =
        parse_scene(
            "[world]\nduration = 0.1\n[body.pad]\nmodel = \"sfem\"\n"
            "block = { size = [0.06, 0.06, 0.03], count = [10, 10, 5] }\nfixed = \"bottom\"\nyoung = 5e3\n"
            "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\n"
            "press = { at_fraction = [0.5, 0.5, 1], depth = 0.003, start = 0, duration = 0.1 }\n",
            folder / "pad.toml", {"body.pad.cache=" + (folder / "cache").string()})
            .value();
    start();
  }
  ~WarmScene() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  WarmScene(const WarmScene&) = delete;
  WarmScene& operator=(const WarmScene&) = delete;
  bool start() const { return load_world(Exec(1), scene).value().sfem_bodies[0].facts.from_cache; }
};

/// Time of the starts [s]; `all_cached` becomes false if one did not read the cache.
double seconds_of_starts(const WarmScene& warm, bool in_threads, bool& all_cached) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::thread> threads;
  std::vector<char> from_cache(kWorlds);
  for (int n = 0; n < kWorlds; n++) {
    const auto start = [&, n] { from_cache[std::size_t(n)] = warm.start(); };
    in_threads ? (void)threads.emplace_back(start) : start();
  }
  for (std::thread& thread : threads) thread.join();
  for (const char cached : from_cache) all_cached = all_cached && cached;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Time of the starts in threads; "ratio" is that to the starts in turn, which precede them.
void warm_worlds(benchmark::State& state) {
  const WarmScene warm;
  double in_turn = 0, in_threads = 0;
  bool all_cached = true;
  for (auto _ : state) {
    in_turn += seconds_of_starts(warm, false, all_cached);
    const double seconds = seconds_of_starts(warm, true, all_cached);
    in_threads += seconds;
    state.SetIterationTime(seconds);
  }
  const double ratio = in_threads / in_turn;
  state.counters["in_turn_s"] = in_turn / double(state.iterations());
  state.counters["ratio"] = ratio;
  if (!all_cached) state.SkipWithError("a world did not read its cache");
  if (ratio > kMostRatio) state.SkipWithError("threads take more than twice the time of starts in turn");
}
BENCHMARK(warm_worlds)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(2);

}  // namespace

BENCHMARK_MAIN();

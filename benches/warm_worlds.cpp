// Start of 64 worlds whose Green's functions are cached, in turn and in 64 threads: what a vector environment
// does at every start. Threads should need at most twice the time.
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

void warm_worlds(benchmark::State& state) {
  const WarmScene warm;
  const bool in_threads = state.range(0);
  for (auto _ : state) {
    std::vector<std::thread> threads;
    std::vector<char> from_cache(kWorlds);
    for (int n = 0; n < kWorlds; n++) {
      const auto start = [&, n] { from_cache[std::size_t(n)] = warm.start(); };
      in_threads ? (void)threads.emplace_back(start) : start();
    }
    for (std::thread& thread : threads) thread.join();
    for (const char cached : from_cache)
      if (!cached) state.SkipWithError("a world did not read its cache");
  }
}
BENCHMARK(warm_worlds)->Arg(0)->Arg(1)->ArgName("threads")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();

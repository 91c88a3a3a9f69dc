// Deformed CT of data set A (512×512×300, block 4), half of it body, at half and at full resolution, on one
// and two threads.
#include "turgor/models/lattice/resample/resample.hpp"

#include <cmath>

#include <benchmark/benchmark.h>

#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace {

using namespace turgor;
using namespace turgor::lattice;

struct Scene {
  CtVolume ct;
  Model model;
  State state;
};

/// A sheared and bent tube of tissue with the texture of a CT.
const Scene& scene() {
  static const Scene made = [] {
    const Int3 size{512, 512, 300};
    CtVolume ct{.grid = {.size = size, .spacing = {7e-4, 7e-4, 1e-3}, .origin = {}, .axes = {}},
                .samples = std::vector<std::int16_t>(
                    sample_count({.size = size, .spacing = {}, .origin = {}, .axes = {}}))};
    for (int k = 0; k < size.z; k++)
      for (int j = 0; j < size.y; j++)
        for (int i = 0; i < size.x; i++) {
          const double x = (i - 255.5) / 230, y = (j - 255.5) / 180;
          ct.at(i, j, k) = x * x + y * y < 1 ? std::int16_t((i * 37 + j * 91 + k * 53) % 101 - 40) : kAirHu;
        }
    Params params;
    params.skin.enabled = false;
    Model model = build(Exec(2), ct, {}, params).value();
    State state = make_state(model);
    for (int k = 0; k < model.anatomy.lattice.size.z; k++)
      for (int j = 0; j < model.anatomy.lattice.size.y; j++)
        for (int i = 0; i < model.anatomy.lattice.size.x; i++)
          state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, i, j, k)),
                             {Real(0.01 * std::sin(0.05 * j)), Real(0.01 * std::cos(0.06 * k)),
                              Real(0.005 * std::sin(0.07 * i))});
    return Scene{std::move(ct), std::move(model), std::move(state)};
  }();
  return made;
}

void bench_resample(benchmark::State& state) {
  const Scene& s = scene();
  const Exec exec(int(state.range(0)));
  const Grid out = resized(s.ct.grid, state.range(1) ? Int3{512, 512, 300} : Int3{256, 256, 150});
  for (auto _ : state)
    benchmark::DoNotOptimize(resample_ct(exec, s.model, s.state, s.ct, out).ct.samples.data());
  state.counters["voxels/s"] =
      benchmark::Counter(double(sample_count(out)), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(bench_resample)
    ->ArgsProduct({{1, 2}, {0, 1}})
    ->ArgNames({"threads", "full"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void bench_surface(benchmark::State& state) {
  const Scene& s = scene();
  for (auto _ : state) benchmark::DoNotOptimize(build_surface(s.model, s.state.cuts).rest.data());
}
BENCHMARK(bench_surface)->Unit(benchmark::kMillisecond)->UseRealTime();

void bench_deformed_surface(benchmark::State& state) {
  const Scene& s = scene();
  const BodySurface surface = build_surface(s.model, s.state.cuts);
  for (auto _ : state)
    benchmark::DoNotOptimize(deformed_surface(s.model, s.state, surface, Shown::kStretch).vertices.data());
  state.counters["vertices"] = double(surface.rest.size());
}
BENCHMARK(bench_deformed_surface)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();

// The haptic tick: its cost over contact points and over the points of the patch, and its percentiles. The
// displacement of all points is a dense matrix–vector product; the speed of a plain one is measured for
// comparison.
#include <cmath>

#include <benchmark/benchmark.h>

#include "tests/contact/half_space.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/timing.hpp"

namespace turgor::contact {
namespace {

constexpr double kTick = 1e-3, kRadius = 5e-3;

/// A sphere that slides in a circle at 100 mm/s over a grid of points, dense enough that about `contacts`
/// touch.
struct Slide {
  HalfSpace space;
  sfem::Patch patch;
  std::vector<Tool> tools{{Sphere{kRadius}, 0.3}};
  TouchState state;
  std::vector<ToolForce> forces{1};
  std::vector<ToolPose> poses{1};
  double depth, angle = 0;

  Slide(int contacts, int side)
      : space{.side = side, .spacing = 10e-3 / (side - 1)},
        patch(half_space_patch(space)),
        state(make_touch_state(patch, 1, {.capacity = 40})) {
    // Under a sphere pressed by d, points within sqrt(R d) touch.
    depth = contacts * space.spacing * space.spacing / (3.14159265 * kRadius);
    for (int i = 0; i < 1000; i++) tick();
  }
  void tick() {
    constexpr double kCircle = 1.5e-3;
    angle += 0.1 * kTick / kCircle;
    poses[0].pose.position = {kCircle * std::cos(angle), kCircle * std::sin(angle), kRadius - depth};
    solve_touch_tick(patch, state, tools, poses, kTick, forces);
  }
};

void tick(benchmark::State& bench) {
  Slide slide(int(bench.range(0)), int(bench.range(1)));
  std::vector<double> times;
  double contacts = 0, sweeps = 0, newton = 0, sites = 0;
  for (auto _ : bench) {
    const Timer timer;
    slide.tick();
    times.push_back(1e6 * timer.seconds());
    contacts += slide.forces[0].contacts;
    sites += double(slide.state.sites.size());
    sweeps += slide.state.solution.sweeps;
    newton += slide.state.solution.newton_steps;
  }
  const auto count = double(times.size());
  bench.counters["points"] = double(slide.patch.points.size());
  bench.counters["contacts"] = contacts / count;
  bench.counters["sites"] = sites / count;
  bench.counters["sweeps"] = sweeps / count;
  bench.counters["newton"] = newton / count;
  bench.counters["p50_us"] = median(times);
  bench.counters["p99_us"] = percentile(times, 0.99);
}
BENCHMARK(tick)
    ->ArgsProduct({{1, 3, 10, 20, 30}, {11, 17}})
    ->ArgNames({"contacts", "side"})
    ->Unit(benchmark::kMicrosecond);

/// u = Ξ f with `loaded` points as in a tick, and the bytes of Ξ that it reads.
void displace(benchmark::State& bench) {
  const int loaded = int(bench.range(0)), side = int(bench.range(1));
  Slide slide(10, side);
  const std::size_t n = slide.patch.points.size();
  slide.state.sites.clear();
  for (int i = 0; i < loaded; i++) {
    Site site{.point = {int(std::size_t(i) * n / std::size_t(loaded)), -1, -1}, .weight = {1, 0, 0}};
    site.force = {0, 0, 1};
    slide.state.sites.push_back(site);
  }
  for (auto _ : bench) {
    move_points(slide.patch, {}, slide.state);
    benchmark::ClobberMemory();
  }
  bench.SetBytesProcessed(bench.iterations() * std::int64_t(9 * n * std::size_t(loaded) * sizeof(double)));
}
BENCHMARK(displace)
    ->ArgsProduct({{10, 30}, {11, 17}})
    ->ArgNames({"loaded", "side"})
    ->Unit(benchmark::kMicrosecond);

/// Plain matrix–vector product of the same size, by columns.
void gemv(benchmark::State& bench) {
  const auto rows = std::size_t(3 * bench.range(1) * bench.range(1)),
             columns = std::size_t(3 * bench.range(0));
  std::vector<double> a(rows * columns, 1.0), x(columns, 1.0), y(rows);
  for (auto _ : bench) {
    for (std::size_t j = 0; j < columns; j += 2) {
      const double *c = &a[j * rows], *d = c + rows;
      for (std::size_t i = 0; i < rows; i++) y[i] += c[i] * x[j] + d[i] * x[j + 1];
    }
    benchmark::ClobberMemory();
  }
  bench.SetBytesProcessed(bench.iterations() * std::int64_t(rows * columns * sizeof(double)));
}
BENCHMARK(gemv)
    ->ArgsProduct({{10, 30}, {11, 17}})
    ->ArgNames({"loaded", "side"})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace turgor::contact

BENCHMARK_MAIN();

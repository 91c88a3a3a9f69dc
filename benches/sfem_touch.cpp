// The haptic tick: its cost over contact points and over the points of the patch, and its percentiles. The
// displacement of all points is a dense matrix–vector product; the speed of a plain one is measured for
// comparison. Goals and their limit, as medians of five interleaved rounds:
//
//   bench_sfem_touch --benchmark_filter='goal|limit' --benchmark_repetitions=5
//     --benchmark_enable_random_interleaving=true --benchmark_report_aggregates_only=true
#include <Eigen/Dense>
#include <cmath>
#include <ctime>

#include <benchmark/benchmark.h>

#include "tests/contact/half_space.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/models/sfem/patch.hpp"

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

/// The finely meshed middle of the top of a block of 12 cm, as `turgor bench sfem` touches it.
sfem::Patch block_patch(Vec3d top) {
  const Exec exec(2);
  sfem::Body body;
  body.mesh = hex_block({0.12, 0.12, 0.06}, {12, 12, 6});
  body.materials = {{3e3, 0.45}};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < 1e-9);
  sfem::Model model = sfem::build(exec, std::move(body), {.touch_depth = 1}).value();
  if (!sfem::compute_green(exec, model, std::size_t(1) << 30)) std::abort();
  const std::vector<Vec3d> touches{top};
  return sfem::build_patch(model, sfem::patch_elements(model, touches, 0.02), 3, touches).value();
}

/// Points of a half space, so dense that a ball of 5 mm touches about 300; clusters bear its force.
sfem::Patch wide_patch() {
  sfem::Patch patch = half_space_patch({.side = 33, .spacing = 10e-3 / 32});
  sfem::add_levels(patch);
  return patch;
}

/// Processor time of this thread, which other programs do not lengthen much [s].
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Ticks of a ball that slides in a circle at 100 mm/s with about `contacts` touched points. Goals: median
/// 20, 45 and 150 µs for 12, 20 and 34 contacts, at worst 500 µs for 300.
void goal(benchmark::State& bench) {
  const auto contacts = bench.range(0);
  const bool wide = contacts == 300;
  const Vec3d top = wide ? Vec3d{} : Vec3d{0.06, 0.06, 0.06};
  static const sfem::Patch fine = block_patch({0.06, 0.06, 0.06}), dense = wide_patch();
  const double radius = wide ? 5e-3 : 15e-3, circle = wide ? 1.5e-3 : 3e-3;
  const double depth = wide ? 2.3e-3 : contacts == 12 ? 2e-3 : contacts == 20 ? 4e-3 : 8e-3;
  const sfem::Patch& patch = wide ? dense : fine;
  const std::vector<Tool> tools{{Sphere{radius}, 0.3}};
  TouchState state = make_touch_state(patch, 1, {.capacity = 48});
  std::vector<ToolPose> poses(1);
  std::vector<ToolForce> forces(1);
  std::vector<double> times, sites, sweeps, newton;
  int n = 0;
  const auto next = [&] {
    constexpr int kWarm = 200;
    const double angle = 0.1 * kTick / circle * n;
    const double pressed = std::min(1.0, double(n++) / kWarm) * (depth + 1e-3);
    poses[0].pose.position =
        top + Vec3d{circle * std::cos(angle), circle * std::sin(angle), radius + 1e-3 - pressed};
    const double before = thread_seconds();
    solve_touch_tick(patch, state, tools, poses, kTick, forces);
    return 1e6 * (thread_seconds() - before);
  };
  while (n < 200) next();
  for (auto _ : bench) {
    times.push_back(next());
    sites.push_back(forces[0].contacts);
    sweeps.push_back(state.solution.sweeps), newton.push_back(state.solution.newton_steps);
  }
  bench.counters["sites"] = median(sites);
  bench.counters["p50_us"] = median(times);
  bench.counters["p99_us"] = percentile(times, 0.99);
  bench.counters["worst_us"] = percentile(times, 1);
  bench.counters["sweeps"] = percentile(sweeps, 1);
  bench.counters["newton"] = percentile(newton, 1);
}
BENCHMARK(goal)->Arg(12)->Arg(20)->Arg(34)->Arg(300)->ArgName("touched")->Iterations(2000)->Unit(
    benchmark::kMicrosecond);

/// The least that a tick of k sliding contacts does: one solution of its active set, of 2k unknowns, with
/// 2/3 (2k)³ operations and 72 k² bytes of C.
void limit(benchmark::State& bench) {
  const auto n = Eigen::Index(2 * bench.range(0));
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(n, n) + 10 * Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(n);
  Eigen::PartialPivLU<Eigen::MatrixXd> lu(n);
  for (auto _ : bench) {
    lu.compute(a);
    benchmark::DoNotOptimize(lu.solve(b).eval());
  }
  const double flops = 2.0 / 3 * double(n * n * n);
  bench.counters["flops"] = flops;
  bench.counters["bytes"] = 18 * double(n * n);
  bench.counters["flop/s"] =
      benchmark::Counter(flops * double(bench.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(limit)->Arg(12)->Arg(20)->Arg(34)->ArgName("contacts")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace turgor::contact

BENCHMARK_MAIN();

// A tick of a needle with 60 points on its shaft: moving in its track, cutting, and held, rigid and bending.
// The goal is 100 µs for rigid needles; the limit of a haptic tick is 1 ms. Quantiles are processor time,
// which other programs change least.
#include <algorithm>
#include <ctime>
#include <vector>

#include <benchmark/benchmark.h>

#include "turgor/contact/needle_touch.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor::contact {
namespace {

constexpr double kDeep = 0.060;  // 60 points [m]

const sfem::InnerGreen& bench_block(bool is_quadratic) {
  static const auto make = [](bool quadratic) {
    sfem::Body body;
    body.mesh = hex_block({0.06, 0.06, 0.1}, {5, 5, 8});
    if (quadratic) body.mesh = tetrahedralize(body.mesh);
    for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < 1e-9);
    body.materials = {{4e3, 0.45}};
    if (quadratic) body = sfem::with_middles(std::move(body));
    sfem::Model model = *sfem::build(Exec(2), std::move(body), {});
    (void)sfem::factorize(Exec(2), model);
    std::vector<int> elements;
    for (std::size_t e = 0; e < element_count(model.body.mesh); e++) {
      const Vec3d d = centroid(model.body.mesh, e) - Vec3d{0.031, 0.028, 0};
      if (d.x * d.x + d.y * d.y < 4e-4) elements.push_back(int(e));
    }
    return sfem::make_inner_green(Exec(2), model, elements);
  };
  static const sfem::InnerGreen hexahedra = make(false), tetrahedra = make(true);
  return is_quadratic ? tetrahedra : hexahedra;
}

/// Processor time of this thread [s].
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Needle with its tip at a depth [m].
struct BenchNeedle {
  const sfem::InnerGreen& inner;
  Needle needle{.length = 0.09};
  Pose pose{{0.031, 0.028, 0.1005}, {}};
  NeedleState state = make_needle_state(inner, needle);

  void move(double down) {
    pose.position.z -= down;
    tick_needle(inner, needle, {}, pose, 1, state);
  }
  void move_to(double depth) {
    while (0.1 - pose.position.z < depth) move(1e-4);
  }
};

enum class Motion { kHeld, kStroke, kCut };

void needle_tick(benchmark::State& bench) {
  const auto motion = Motion(bench.range(1));
  BenchNeedle needle{.inner = bench_block(bench.range(0) != 0)};
  if (const bool bends = bench.range(2) != 0; bends)
    needle.needle.bending = bending_stiffness(needle.needle.diameter, kSteel), needle.needle.bevel = 30;
  needle.move_to(kDeep + 0.003);
  std::vector<double> times;
  int n = 0;
  double points = 0, sweeps = 0;
  for (auto _ : bench) {
    // strokes of 4 mm in the track; cutting starts again after 8 mm
    if (motion == Motion::kCut && needle.state.inserted > kDeep + 0.008) {
      bench.PauseTiming();
      needle.pose = {{0.031, 0.028, 0.1005}, {}},
      needle.state = make_needle_state(needle.inner, needle.needle);
      needle.move_to(kDeep + 0.003);
      bench.ResumeTiming();
    }
    const double step = motion == Motion::kHeld  ? 0
                        : motion == Motion::kCut ? 5e-5
                        : n++ / 80 % 2           ? 5e-5
                                                 : -5e-5;
    const double begin = thread_seconds();
    needle.move(step);
    times.push_back((thread_seconds() - begin) * 1e6);
    const auto& track = needle.state.tracks[std::size_t(needle.state.track)];
    points += double(track.points.size()), sweeps += needle.state.sweeps;
  }
  std::sort(times.begin(), times.end());
  bench.counters["points"] = points / double(times.size());
  bench.counters["sweeps"] = sweeps / double(times.size());
  bench.counters["p50_us"] = times[times.size() / 2];
  bench.counters["p99_us"] = times[times.size() * 99 / 100];
}
BENCHMARK(needle_tick)
    ->ArgsProduct({{0, 1}, {0, 1, 2}, {0, 1}})
    ->ArgNames({"quadratic", "motion", "bends"})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace turgor::contact

BENCHMARK_MAIN();

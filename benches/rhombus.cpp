// Cost of a touch: force of a haptic tick, deformed surface, and surface distances recomputed during sliding.
// The paper: < 1 ms for a force, 52 ms for a picture of 3116 vertices.
#include "turgor/models/rhombus/rhombus.hpp"

#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>

#include "turgor/geometry/phantom_liver.hpp"

namespace turgor::rhombus {
namespace {

Model liver(double vertices, const Params& params = {}) {
  const TriMesh mesh = phantom_liver(std::sqrt(vertices / 3116));
  Body body{.triangles = mesh.triangles};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  return *build(std::move(body), params);
}

/// A ball of 5 mm that slides 2 cm and back over the right lobe, 8 to 10 mm below its surface.
std::vector<TouchInput> path(const Model& model, int ticks) {
  std::vector<TouchInput> inputs;
  for (int i = 0; i < ticks; i++) {
    const double fraction = std::abs(2.0 * i / ticks - 1);
    const FootPoint foot =
        find_foot_point(model.surface, model.tree, {-0.05 + 0.02 * fraction, 0.01 + 0.005 * fraction, 0.2});
    const double depth = 0.008 + 0.002 * fraction;
    inputs.push_back({.position = foot.at.position + foot.normal * (0.005 - depth), .radius = 0.005});
  }
  return inputs;
}

void force(benchmark::State& bench) {
  const Model model = liver(double(bench.range(0)));
  State state = make_state(model, 1);
  const std::vector<TouchInput> inputs = path(model, 4000);
  TouchForce out;
  std::size_t i = 0;
  for (auto _ : bench) {
    solve_touches(model, state, {&inputs[i], 1}, 1e-3, {&out, 1});
    benchmark::DoNotOptimize(out);
    i = (i + 1) % inputs.size();
  }
  bench.counters["depth_mm"] = out.depth * 1e3;
  bench.counters["units"] = out.units;
}
BENCHMARK(force)->Arg(3116)->Arg(100000)->ArgName("vertices")->Unit(benchmark::kMicrosecond);

void picture(benchmark::State& bench, double bulge, bool slide) {
  const Exec exec(1);
  const Model model = liver(double(bench.range(0)), {.bulge = bulge});
  State state = make_state(model, 1);
  const std::vector<TouchInput> inputs = path(model, 4000);
  TouchForce out;
  std::size_t i = 0;
  for (auto _ : bench) {
    TouchInput in = inputs[slide ? i : 0];
    in.position.z += 1e-8 * double(i % 2);  // another depth, so that no result can be reused
    solve_touches(model, state, {&in, 1}, 1e-3, {&out, 1});
    benchmark::DoNotOptimize(step(exec, model, state));
    i = (i + 16) % inputs.size();
  }
  bench.counters["moved"] = double(state.moved.size());
  bench.SetItemsProcessed(bench.iterations() * std::int64_t(model.surface.vertices.size()));
}
void picture_of_a_press(benchmark::State& bench) { picture(bench, 0, false); }
void picture_with_bulge(benchmark::State& bench) { picture(bench, 1, false); }
void picture_while_sliding(benchmark::State& bench) { picture(bench, 0, true); }
void sizes(benchmark::internal::Benchmark* b) {
  for (const int vertices : {3116, 12500, 50000, 100000}) b->Arg(vertices);
  b->ArgName("vertices")->Unit(benchmark::kMillisecond);
}
BENCHMARK(picture_of_a_press)->Apply(sizes);
BENCHMARK(picture_with_bulge)->Apply(sizes);
BENCHMARK(picture_while_sliding)->Apply(sizes);

}  // namespace
}  // namespace turgor::rhombus

BENCHMARK_MAIN();

// Frames and sweeps of the cloth model over sizes, and random steps that must stay finite and free of
// self-intersections. Rates: vertices per second, and the least memory traffic of a sweep.
#include <benchmark/benchmark.h>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "tests/models/cloth/storm.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {
namespace {

struct Flag {
  Model model;
  State state;
  Inputs inputs{.gravity = {0, 0, -9.81}};
};

/// A square of n × n vertices, 1 cm apart, held along its first column, in gusts.
Flag flying_flag(const Exec& exec, int n, bool self) {
  Params params;
  params.solver = {.method = Method::kChebyshev, .sweeps = 8};
  params.collision = {.self = self, .thickness = 0.0096};
  Flag flag{.model = must_build(flat_sheet(n), params), .state = {}};
  flag.state = make_state(flag.model);
  for (int j = 0; j < n; j++) (void)hold(flag.model, flag.state, j * n);
  flag.inputs.air.velocity = {6, 0, 2};
  flag.inputs.air.gusts = 0.3;
  for (int frame = 0; frame < 30; frame++) step(exec, flag.model, flag.state, flag.inputs, kFrame);
  return flag;
}

void frame(benchmark::State& bench, bool self) {
  const Exec exec(static_cast<int>(bench.range(1)));
  Flag flag = flying_flag(exec, static_cast<int>(bench.range(0)), self);
  for (auto _ : bench) step(exec, flag.model, flag.state, flag.inputs, kFrame);
  bench.counters["vertices/s"] =
      benchmark::Counter(flag.model.count, benchmark::Counter::kIsIterationInvariantRate);
  bench.counters["bytes/vertex"] = double(memory_bytes(flag.model, flag.state)) / flag.model.count;
}
void frame_alone(benchmark::State& bench) { frame(bench, false); }
void frame_with_self_collision(benchmark::State& bench) { frame(bench, true); }

void sweeps(benchmark::State& bench) {
  const Exec exec(static_cast<int>(bench.range(1)));
  Flag flag = flying_flag(exec, static_cast<int>(bench.range(0)), false);
  for (auto _ : bench) sweep(exec, flag.model, flag.state, 1);
  bench.SetBytesProcessed(bench.iterations() * std::int64_t(8 * flag.model.rows.stiffness.size() +
                                                            4 * flag.model.far_rows.bend.size() +
                                                            80 * std::size_t(flag.model.count)));
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgsProduct({{50, 100, 316, 1000}, {1, 2}})
      ->ArgNames({"side", "threads"})
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}
BENCHMARK(frame_alone)->Apply(sizes);
BENCHMARK(frame_with_self_collision)->Apply(sizes);
BENCHMARK(sweeps)->Apply(sizes);

/// A hundred frames of a sheet with cells of 5 mm that falls over a ball. The argument is the ratio of its
/// longest edges to the thickness [%].
void fall_over_a_ball(benchmark::State& bench) {
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = Method::kTwoLevel, .sweeps = 200}};
  params.collision.thickness = 0.005 * std::sqrt(2.0) / (double(bench.range(0)) / 100);
  TriMesh mesh = rectangle(Pattern::kAlternating, -0.15, 0.15, 0.3, 0.005);
  for (Vec3& x : mesh.vertices) x += Vec3{0.004f, -0.145f, 0.065f};
  const Model model = must_build(mesh, params);
  const contact::Shape ball = contact::Sphere{0.05};
  Inputs inputs = in_vacuum();
  inputs.obstacles.push_back(contact::cloth_obstacle(ball, {}, {}, kFrame));
  for (auto _ : bench) {
    State state = make_state(model);
    for (int n = 0; n < 100; n++) step(Exec(1), model, state, inputs, kFrame);
  }
}
BENCHMARK(fall_over_a_ball)->Arg(148)->Arg(152)->Unit(benchmark::kMillisecond);

void random_step(benchmark::State& bench) {
  Params params;
  params.collision.thickness = 0.0096;
  const Model model = must_build(flat_sheet(9), params);
  State state = make_state(model);
  const Exec exec(1);
  RandomNumbers next{7};
  for (auto _ : bench) {
    if (!storm_step(exec, model, state, next, true).finite) {
      bench.SkipWithError("a step was not finite");
      return;
    }
    if (!crossing_triangles(exec, model_surface(model, state)).empty()) {
      bench.SkipWithError("the cloth crosses itself");
      return;
    }
  }
}
BENCHMARK(random_step)->Iterations(100000);

}  // namespace
}  // namespace turgor::cloth

BENCHMARK_MAIN();

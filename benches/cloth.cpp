// Frames and sweeps of the cloth model over sizes, and random steps that must stay finite and free of
// crossings. Rates: vertices a second; bytes a sweep must move at least.
#include <benchmark/benchmark.h>

#include "tests/models/cloth_sheets.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/models/cloth/system.hpp"

namespace turgor::cloth {
namespace {

struct Flag {
  Model model;
  State state;
  Inputs inputs{.gravity = {0, 0, -9.81}};
};

/// A square of n × n vertices a centimetre apart, held at its first column, in gusts.
Flag flying_flag(const Exec& exec, int n, bool self) {
  Params params;
  params.solver.sweeps = 8;
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
  bench.SetBytesProcessed(bench.iterations() *
                          std::int64_t(8 * flag.model.rows.rest.size() + 76 * std::size_t(flag.model.count)));
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

void random_step(benchmark::State& bench) {
  Params params;
  params.collision.thickness = 0.0096;
  const Model model = must_build(flat_sheet(9), params);
  State state = make_state(model);
  const Exec exec(1);
  std::uint64_t bits = 7;
  const auto next = [&bits] {
    bits = bits * 6364136223846793005ull + 1442695040888963407ull;
    return double(bits >> 40) / double(1 << 23) - 1;
  };
  for (auto _ : bench) {
    const int vertex = int(40 + 40 * next());
    if (next() > 0.95) (void)hold(model, state, vertex);
    if (next() > 0.95) (void)release(model, state, vertex);
    (void)move_hold(model, state, vertex, Vec3(Vec3d{next(), next(), next()} * 0.2));
    Inputs inputs{.gravity = Vec3d{next(), next(), next()} * 20.0};
    inputs.air.velocity = Vec3d{next(), next(), next()} * 30.0;
    inputs.air.gusts = 0.5 + 0.5 * next();
    if (!step(exec, model, state, inputs, 0.017 + 0.016 * next()).finite) {
      bench.SkipWithError("a step was not finite");
      return;
    }
    if (!crossing_triangles(exec, surface(model, state)).empty()) {
      bench.SkipWithError("the cloth crosses itself");
      return;
    }
  }
}
BENCHMARK(random_step)->Iterations(100000);

}  // namespace
}  // namespace turgor::cloth

BENCHMARK_MAIN();

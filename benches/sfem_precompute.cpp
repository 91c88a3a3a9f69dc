// All Green's functions of a mesh over sizes: assembly, sparse factorization, every column. The rate of a
// dense product in the same run is the reference, because other load on the machine slows both. `store` and
// `factor` are what stays in memory.
#include <Eigen/Dense>

#include <benchmark/benchmark.h>

#include "tests/models/sfem/bodies.hpp"
#include "turgor/core/gpu.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor::sfem {
namespace {

enum Kind { kHexahedra, kTetrahedra, kAveragedTetrahedra };

/// A block fixed at its bottom with about `nodes` free nodes.
Model block_of_nodes(const Exec& exec, std::int64_t nodes, std::int64_t kind) {
  const Int3 cells = nodes == 1000    ? Int3{9, 9, 10}
                     : nodes == 3000  ? Int3{14, 19, 10}
                     : nodes == 10000 ? Int3{24, 19, 20}
                                      : Int3{35, 36, 37};
  SolidMesh mesh = hex_block({0.1, 0.1, 0.1}, cells);
  if (kind != kHexahedra) mesh = tetrahedralize(mesh);
  Body body = block_of(std::move(mesh), {3e3, 0.45}, [](Vec3d x) { return x.z < 1e-9; });
  const Formulation formulation =
      kind == kAveragedTetrahedra ? Formulation::kAveraged : Formulation::kStandard;
  return build(exec, std::move(body), {.formulation = formulation, .touch_depth = nodes > 10000 ? 0.0 : 1.0})
      .value();
}

/// Rate of a dense product on one core, best of five [1/s].
double dense_rate() {
  constexpr Eigen::Index kSide = 768;
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(kSide, kSide), b = Eigen::MatrixXd::Random(kSide, kSide);
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(kSide, kSide);
  double best = 0;
  for (int i = 0; i < 5; i++) {
    const Timer timer;
    c.noalias() += a * b;
    best = std::max(best, 2.0 * kSide * kSide * kSide / timer.seconds());
  }
  benchmark::DoNotOptimize(c.data());
  return best;
}

void precompute(benchmark::State& bench) {
  const Exec exec(static_cast<int>(bench.range(2)));
  const double dense = dense_rate();
  double seconds = 0;
  GreenCost cost;
  for (auto _ : bench) {
    const Timer timer;
    Model model = block_of_nodes(exec, bench.range(0), bench.range(1));
    cost = green_cost(model);
    if (const Status s = compute_green(exec, model, std::size_t(16) << 30); !s)
      return bench.SkipWithError(s.error().message.c_str());
    seconds += timer.seconds();
  }
  const double rate = (cost.factor_flops + cost.solve_flops) * double(bench.iterations()) / seconds;
  bench.counters["factor_MB"] = double(cost.factor_bytes) * 1e-6;
  bench.counters["store_MB"] = double(cost.store_bytes) * 1e-6;
  bench.counters["Gflop/s"] = rate * 1e-9;
  bench.counters["dense_Gflop/s"] = dense * double(bench.range(2)) * 1e-9;
}
BENCHMARK(precompute)
    ->ArgsProduct({{1000, 3000, 10000}, {kHexahedra, kTetrahedra, kAveragedTetrahedra}, {2}})
    ->ArgNames({"nodes", "kind", "threads"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// All columns on a GPU, from an existing factorization. Small bodies: between all nodes; large ones: between
/// surface nodes only.
void columns_on_gpu(benchmark::State& bench) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) return bench.SkipWithError(gpu.error().message.c_str());
  const Exec exec(2);
  Model model = block_of_nodes(exec, bench.range(0), kHexahedra);
  if (const Status s = factorize(exec, model); !s) return bench.SkipWithError(s.error().message.c_str());
  const GreenCost cost = green_cost(model);
  double seconds = 0;
  for (auto _ : bench) {
    const Timer timer;
    if (const Status s = compute_green(exec, model, std::size_t(64) << 30, {}, &*gpu); !s)
      return bench.SkipWithError(s.error().message.c_str());
    seconds += timer.seconds();
  }
  bench.counters["kept_nodes"] = double(model.green.nodes.size());
  bench.counters["store_MB"] = double(cost.store_bytes) * 1e-6;
  bench.counters["Gflop/s"] = cost.solve_flops * double(bench.iterations()) / seconds * 1e-9;
}
BENCHMARK(columns_on_gpu)
    ->Arg(1000)
    ->Arg(10000)
    ->Arg(50000)
    ->ArgName("nodes")
    ->Iterations(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// One right-hand side, and the columns of eight nodes on demand, from an existing factorization.
void solve_one(benchmark::State& bench) {
  const Exec exec(2);
  Model model = block_of_nodes(exec, bench.range(0), kHexahedra);
  if (const Status s = factorize(exec, model); !s) return bench.SkipWithError(s.error().message.c_str());
  std::vector<double> f(3 * model.vertex.size(), 1.0);
  for (auto _ : bench) solve(*model.factor, f);
  bench.SetBytesProcessed(bench.iterations() * std::int64_t(16 * model.factor->plan.value_count));
}
void columns_of_eight_nodes(benchmark::State& bench) {
  const Exec exec(1);
  Model model = block_of_nodes(exec, bench.range(0), kHexahedra);
  if (const Status s = prepare_columns(exec, model); !s)
    return bench.SkipWithError(s.error().message.c_str());
  const std::vector<int> vertices(model.green.nodes.begin(), model.green.nodes.begin() + 8);
  for (auto _ : bench) benchmark::DoNotOptimize(compute_columns(exec, model, vertices));
}
BENCHMARK(solve_one)->Arg(1000)->Arg(3000)->Arg(10000)->ArgName("nodes")->Unit(benchmark::kMillisecond);
BENCHMARK(columns_of_eight_nodes)
    ->Arg(1000)
    ->Arg(3000)
    ->Arg(10000)
    ->ArgName("nodes")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace turgor::sfem

BENCHMARK_MAIN();

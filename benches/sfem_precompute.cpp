// All Green's functions of a mesh over sizes: assembly, sparse factorization, every column. The rate of a
// dense product in the same run is the reference, because other load on the machine slows both. `store` and
// `factor` are what stays in memory.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "tests/models/sfem/bodies.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/gpu.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor::sfem {
namespace {

enum Kind { kHexahedra, kTetrahedra, kAveragedTetrahedra };

/// A block fixed at its bottom with about `nodes` free nodes. Small ones keep Green's functions of all nodes.
Model block_of_nodes(const Exec& exec, std::int64_t nodes, std::int64_t kind, double depth) {
  const Int3 cells = nodes == 1000    ? Int3{9, 9, 10}
                     : nodes == 3000  ? Int3{14, 19, 10}
                     : nodes == 10000 ? Int3{24, 19, 20}
                                      : Int3{35, 36, 37};
  SolidMesh mesh = hex_block({0.1, 0.1, 0.1}, cells);
  if (kind != kHexahedra) mesh = tetrahedralize(mesh);
  Body body = block_of(std::move(mesh), {3e3, 0.45}, [](Vec3d x) { return x.z < 1e-9; });
  const Formulation formulation =
      kind == kAveragedTetrahedra ? Formulation::kAveraged : Formulation::kStandard;
  return build(exec, std::move(body), {.formulation = formulation, .touch_depth = depth}).value();
}
Model block_of_nodes(const Exec& exec, std::int64_t nodes, std::int64_t kind) {
  return block_of_nodes(exec, nodes, kind, nodes > 10000 ? 0.0 : 1.0);
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

/// Largest memory of this process so far [bytes].
std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::size_t(usage.ru_maxrss) * 1024;
}

/// Median tick of a ball of 5 mm that is pressed 2 mm deep and slides in a circle at 100 mm/s [s].
double tick_seconds(const Patch& patch, Vec3d top) {
  constexpr double kRadius = 5e-3, kDepth = 2e-3, kCircle = 1.5e-3, kTick = 1e-3;
  const std::vector<contact::Tool> tools{{contact::Sphere{kRadius}, 0.3}};
  contact::TouchState state = contact::make_touch_state(patch, 1, {.capacity = 48});
  std::vector<contact::ToolPose> poses(1);
  std::vector<contact::ToolForce> forces(1);
  std::vector<double> seconds;
  for (int n = 0; n < 1200; n++) {
    const double angle = 0.1 * kTick / kCircle * n, depth = std::min(1.0, n / 200.0) * (kDepth + 1e-3);
    poses[0].pose.position =
        top + Vec3d{kCircle * std::cos(angle), kCircle * std::sin(angle), kRadius + 1e-3 - depth};
    const Timer timer;
    contact::solve_touch_tick(patch, state, tools, poses, kTick, forces);
    if (n >= 200) seconds.push_back(timer.seconds());
  }
  return median(seconds);
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

/// A body whose dense store would not fit: its factor, the columns of the usual patch in the middle of its
/// top on demand, that patch, and a tick of a ball on it. Columns reach all nodes, inner ones too. Goal for
/// 50 000 nodes: 2 GB and 60 s.
void on_demand(benchmark::State& bench) {
  const Exec exec(2);
  const Vec3d top{0.05, 0.05, 0.1};
  for (auto _ : bench) {
    Timer timer;
    Model model = block_of_nodes(exec, bench.range(0), bench.range(1), 1.0);
    const GreenCost cost = green_cost(model);
    if (const Status s = prepare_columns(exec, model); !s)
      return bench.SkipWithError(s.error().message.c_str());
    bench.counters["prepare_s"] = timer.seconds();
    // columns and patch
    const std::vector<int> elements = patch_elements(model, std::vector{top}, 0.01);
    std::vector<int> vertices;
    for (const int e : changed_elements(model, elements))
      for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
    sort_unique(vertices);
    timer = Timer();
    fetch_columns(exec, model, vertices);
    bench.counters["columns_ms"] = 1e3 * timer.seconds();
    timer = Timer();
    const Patch patch = build_patch(model, elements, 2, std::vector{top}).value();
    bench.counters["patch_ms"] = 1e3 * timer.seconds();
    bench.counters["tick_us"] = 1e6 * tick_seconds(patch, top);
    bench.counters["columns"] = double(vertices.size());
    bench.counters["columns_MB"] = double(column_bytes(model.green)) * 1e-6;
    bench.counters["factor_MB"] = double(cost.factor_bytes) * 1e-6;
    bench.counters["model_MB"] = double(memory_bytes(model)) * 1e-6;
    bench.counters["peak_MB"] = double(peak_bytes()) * 1e-6;
    bench.counters["dense_store_MB"] = double(cost.store_bytes) * 1e-6;
  }
}
BENCHMARK(on_demand)
    ->ArgsProduct({{10000, 50000}, {kHexahedra, kTetrahedra}})
    ->ArgNames({"nodes", "kind"})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace turgor::sfem

BENCHMARK_MAIN();

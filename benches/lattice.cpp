// Sweeps of the lattice over doubled sizes. Rates: edge projections, node solves and tetrahedra per second,
// and the least memory traffic of a sweep.
#include "turgor/models/lattice/lattice.hpp"

#include <benchmark/benchmark.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

constexpr double kDt = 1.0 / 60;
constexpr double kSweepBytes = 32;  // per slot: read u, w, root; write u

Model tense_block(int nodes_per_side, Method method, bool skin, const TissueParams& tissue) {
  const int n = nodes_per_side;
  Block block{.size = {n, n, n}, .spacing = 0.003, .skin_on_top = true};
  block.is_fixed = [](Int3 p) { return p.z == 0 || p.x == 0; };
  Params params;
  params.solver.method = method;
  params.tissue = tissue;
  params.skin.enabled = skin;
  params.skin.law = method == Method::kPbd ? SkinLaw::kArea : SkinLaw::kFiber;
  return block_model(block, params);
}

void sweep(benchmark::State& bench, Method method, bool skin, const TissueParams& tissue = {}) {
  const Exec exec(static_cast<int>(bench.range(1)));
  const Model model = tense_block(static_cast<int>(bench.range(0)), method, skin, tissue);
  State state = make_state(model);
  const Inputs inputs{.gravity = {0, 0, -9.81}};
  predict(exec, model, state, inputs, kDt);
  for (auto _ : bench)
    if (method == Method::kPbd)
      sweep_pbd(exec, model, state);
    else
      sweep_vbd(exec, model, state, inputs, kDt);
  const auto nodes = double(node_count(model.anatomy.lattice));
  bench.counters["nodes"] = nodes;
  bench.counters["edges/s"] = benchmark::Counter((method == Method::kPbd ? 7 : 14) * nodes,
                                                 benchmark::Counter::kIsIterationInvariantRate);
  bench.SetBytesProcessed(bench.iterations() * std::int64_t(kSweepBytes * slot_count(model.anatomy.lattice)));
}

void pbd_sweep(benchmark::State& bench) { sweep(bench, Method::kPbd, false); }
void pbd_sweep_with_skin(benchmark::State& bench) { sweep(bench, Method::kPbd, true); }
void vbd_sweep(benchmark::State& bench) { sweep(bench, Method::kVbd, false); }
void vbd_sweep_with_skin(benchmark::State& bench) { sweep(bench, Method::kVbd, true); }

/// Springs with 24 tetrahedra per node, compared with solid cells.
void vbd_sweep_with_volumes(benchmark::State& bench) { sweep(bench, Method::kVbd, false, {.volume = 2}); }
void vbd_sweep_of_cells(benchmark::State& bench) {
  sweep(bench, Method::kVbd, false, {.law = TissueLaw::kSolid});
}

/// Cells that stiffen, and viscous cells of three pairs, compared with solid cells.
void vbd_sweep_of_exponential_cells(benchmark::State& bench) {
  sweep(bench, Method::kVbd, false,
        {.law = TissueLaw::kSolid, .energy = SolidEnergy::kExponential, .stiffening = 10});
}
void vbd_sweep_of_ogden_cells(benchmark::State& bench) {
  sweep(bench, Method::kVbd, false,
        {.law = TissueLaw::kSolid, .energy = SolidEnergy::kOgden, .stiffening = -10});
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgsProduct({{32, 64, 128, 192}, {1, 2}})
      ->ArgNames({"side", "threads"})
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}
BENCHMARK(pbd_sweep)->Apply(sizes);
BENCHMARK(pbd_sweep_with_skin)->Apply(sizes);
BENCHMARK(vbd_sweep)->Apply(sizes);
BENCHMARK(vbd_sweep_with_skin)->Apply(sizes);
BENCHMARK(vbd_sweep_with_volumes)->Apply(sizes);
BENCHMARK(vbd_sweep_of_cells)->Apply(sizes);
BENCHMARK(vbd_sweep_of_exponential_cells)->Apply(sizes);
BENCHMARK(vbd_sweep_of_ogden_cells)->Apply(sizes);

/// A bar of about 51 000 tetrahedra (and of two and four times as many) with springs and volumes, 5 sweeps.
/// Other engines are timed on the same work.
void bar_frame(benchmark::State& bench) {
  const Exec exec(static_cast<int>(bench.range(1)));
  Params params;
  params.skin.enabled = false;
  params.solver = {.method = Method::kPbd, .pbd_volume = true};
  Block block{.size = {36, 17, static_cast<int>(bench.range(0)) + 1}, .skin_on_top = false};
  block.is_fixed = [](Int3 p) { return p.z == 0; };
  const Model model = block_model(block, params);
  State state = make_state(model);
  for (auto _ : bench) step(exec, model, state, {.gravity = {0, 0, -9.81}}, kDt);
  bench.counters["tets"] = 6.0 * 35 * 16 * double(bench.range(0));
}
BENCHMARK(bar_frame)
    ->ArgsProduct({{15, 30, 60}, {1, 2}})
    ->ArgNames({"cells", "threads"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// A frame of a torso from a CT with its staircase surface, in CPU time of one thread.
void torso_frame(benchmark::State& bench, const TissueParams& tissue, SkinLaw skin = SkinLaw::kFiber) {
  const Exec exec(1);
  PhantomParams phantom = default_phantom(PhantomKind::kTorso);
  const int shrink = static_cast<int>(bench.range(0));
  phantom.size = {phantom.size.x / shrink, phantom.size.y / shrink, phantom.size.z / shrink};
  phantom.spacing *= double(shrink);
  Params params;
  params.tissue = tissue;
  params.skin.law = skin;
  const Model model = build(exec, make_phantom(exec, phantom), {}, params).value();
  State state = make_state(model);
  for (auto _ : bench) step(exec, model, state, {}, kDt);
  bench.counters["nodes"] = double(model.anatomy.body_nodes);
}
void torso_frame_of_springs(benchmark::State& bench) { torso_frame(bench, {}); }
void torso_frame_with_volumes(benchmark::State& bench) { torso_frame(bench, {.volume = 2}); }
void torso_frame_of_cells(benchmark::State& bench) { torso_frame(bench, {.law = TissueLaw::kSolid}); }
void torso_frame_of_exponential_cells(benchmark::State& bench) {
  torso_frame(bench, {.law = TissueLaw::kSolid, .energy = SolidEnergy::kExponential, .stiffening = 10});
}
void torso_frame_of_fibered_cells(benchmark::State& bench) {
  torso_frame(bench, {.law = TissueLaw::kSolid,
                      .energy = SolidEnergy::kExponential,
                      .stiffening = 10,
                      .fiber = {.stiffness = 2e4, .stiffening = 5}});
}
void torso_frame_of_setting_cells(benchmark::State& bench) {
  torso_frame(bench, {.law = TissueLaw::kSolid, .set = {.strain = 0.1, .share = 0.3}});
}
void torso_frame_with_exponential_skin(benchmark::State& bench) {
  torso_frame(bench, {.law = TissueLaw::kSolid}, SkinLaw::kExponential);
}
void torso_frame_of_ogden_cells(benchmark::State& bench) {
  torso_frame(bench, {.law = TissueLaw::kSolid, .energy = SolidEnergy::kOgden, .stiffening = -10});
}
void torso_frame_of_viscous_cells(benchmark::State& bench) {
  Prony prony;
  prony.pairs = {PronyPair{0.8, 0.05}, PronyPair{0.5, 0.5}, PronyPair{0.3, 5}};
  torso_frame(bench, {.law = TissueLaw::kSolid, .prony = prony});
}
BENCHMARK(torso_frame_of_springs)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_with_volumes)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_of_cells)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_of_exponential_cells)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_of_fibered_cells)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_of_setting_cells)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_with_exponential_skin)
    ->Arg(4)
    ->Arg(2)
    ->ArgName("shrink")
    ->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_of_ogden_cells)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);
BENCHMARK(torso_frame_of_viscous_cells)->Arg(4)->Arg(2)->ArgName("shrink")->Unit(benchmark::kMillisecond);

void detect_and_build(benchmark::State& bench) {
  const Exec exec(static_cast<int>(bench.range(1)));
  const int n = static_cast<int>(bench.range(0));
  Block block{.size = {n, n, n}};
  const BodyNodes nodes = block_nodes(block);
  for (auto _ : bench) benchmark::DoNotOptimize(assemble(exec, nodes, nullptr, {}));
}
BENCHMARK(detect_and_build)->Apply(sizes);

}  // namespace
}  // namespace turgor::lattice

BENCHMARK_MAIN();

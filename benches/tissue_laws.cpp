// Frames of a torso whose cells have a law of their own, and of the same torso with neo-Hookean cells, in
// turn on one thread: `of_neo_hookean` is the ratio of their processor times. No row sleeps. The goals
// are 1.3 for the exponential law and 1.25 for three Prony pairs.
#include <array>
#include <ctime>
#include <vector>

#include <benchmark/benchmark.h>

#include "turgor/core/timing.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

constexpr double kDt = 1.0 / 60;
constexpr int kFrames = 30;

/// Processor time of this thread [ms].
double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

void frames(benchmark::State& bench, const TissueParams& tissue) {
  const Exec exec(1);
  PhantomParams phantom = default_phantom(PhantomKind::kTorso);
  const int shrink = static_cast<int>(bench.range(0));
  phantom.size = {phantom.size.x / shrink, phantom.size.y / shrink, phantom.size.z / shrink};
  phantom.spacing *= double(shrink);
  const CtVolume ct = make_phantom(exec, phantom);
  std::vector<Model> models;
  std::vector<State> states;
  for (const TissueParams& of : {TissueParams{.law = TissueLaw::kSolid}, tissue}) {
    Params params;
    params.tissue = of;
    params.skin.law = SkinLaw::kFiber;
    models.push_back(build(exec, ct, {}, params).value());
  }
  for (const Model& model : models) states.push_back(make_state(model));
  std::array<std::vector<double>, 2> times;
  for (auto _ : bench)
    for (int frame = 0; frame < kFrames; frame++)
      for (std::size_t n = 0; n < models.size(); n++) {
        const double begin = thread_time();
        step(exec, models[n], states[n], {}, kDt);
        times[n].push_back(thread_time() - begin);
      }
  bench.counters["ms"] = median(times[1]), bench.counters["neo_hookean_ms"] = median(times[0]);
  bench.counters["of_neo_hookean"] = median(times[1]) / median(times[0]);
  bench.counters["nodes"] = double(models[0].anatomy.body_nodes);
}

TissueParams exponential() {
  return {.law = TissueLaw::kSolid, .energy = SolidEnergy::kExponential, .stiffening = 10};
}
void exponential_cells(benchmark::State& bench) { frames(bench, exponential()); }
void fibered_cells(benchmark::State& bench) {
  TissueParams tissue = exponential();
  tissue.fiber = {.stiffness = 2e4, .stiffening = 5};
  frames(bench, tissue);
}
void ogden_cells(benchmark::State& bench) {
  frames(bench, {.law = TissueLaw::kSolid, .energy = SolidEnergy::kOgden, .stiffening = -10});
}
void three_pairs(benchmark::State& bench) {
  Prony prony;
  prony.pairs = {PronyPair{0.8, 0.05}, PronyPair{0.5, 0.5}, PronyPair{0.3, 5}};
  frames(bench, {.law = TissueLaw::kSolid, .prony = prony});
}
void permanent_set(benchmark::State& bench) {
  frames(bench, {.law = TissueLaw::kSolid, .set = {.strain = 0.1, .share = 0.3}});
}
void sizes(benchmark::internal::Benchmark* b) {
  b->Arg(4)->Arg(2)->ArgName("shrink")->Iterations(1)->Unit(benchmark::kMillisecond);
}
BENCHMARK(exponential_cells)->Apply(sizes);
BENCHMARK(fibered_cells)->Apply(sizes);
BENCHMARK(ogden_cells)->Apply(sizes);
BENCHMARK(three_pairs)->Apply(sizes);
BENCHMARK(permanent_set)->Apply(sizes);

}  // namespace
}  // namespace turgor::lattice

BENCHMARK_MAIN();

// Deformed CT of a body and its picture, as `turgor view` computes them. On a GPU: 512³ voxels, half of them
// body, and 1024² pixels, without any download of the state or the CT. On the CPU, for comparison: an eighth
// of the voxels and a quarter of the pixels.
#include <cmath>

#include <benchmark/benchmark.h>

#include "turgor/models/lattice/device/gpu_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/resample/resample.hpp"
#include "turgor/view/gpu_volume.hpp"
#include "turgor/view/volume_view.hpp"

namespace {

using namespace turgor;
using namespace turgor::lattice;

constexpr ResampleOptions kAlone{.keep_surroundings = false};

struct Scene {
  CtVolume ct;
  Model model;
  State state;
  Camera camera;
};

/// A bent tube of tissue with the texture of a CT, seen from the side; `n` voxels along each axis.
Scene make_scene(int n) {
  const double voxel = 0.36 / n;
  Scene s;
  s.ct.grid = {.size = {n, n, n}, .spacing = {voxel, voxel, voxel}, .origin = {}, .axes = {}};
  s.ct.samples.resize(sample_count(s.ct.grid));
  for (int k = 0; k < n; k++)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) {
        const double x = (2.0 * i / n - 1) / 0.9, y = (2.0 * j / n - 1) / 0.7;
        s.ct.at(i, j, k) = x * x + y * y < 1 ? std::int16_t((i * 37 + j * 91 + k * 53) % 101 - 40) : kAirHu;
      }
  Params params;
  params.skin.enabled = false;
  params.solver.ordering = Ordering::kColors;
  s.model = build(Exec(), s.ct, {}, params).value();
  s.state = make_state(s.model);
  const Int3 size = s.model.anatomy.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        s.state.motion.u.set(
            std::size_t(node_slot(s.model.anatomy.lattice, i, j, k)),
            {Real(0.01 * std::sin(9.0 * j / size.y)), Real(0.01 * std::cos(8.0 * k / size.z)),
             Real(0.005 * std::sin(9.0 * i / size.x))});
  s.camera = {.eye = {0.6, -0.7, 0.4}, .target = {0.18, 0.18, 0.18}};
  return s;
}

void bench_gpu(benchmark::State& state) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) return state.SkipWithError(gpu.error().message.c_str());
  static const Scene s = make_scene(512);
  const int pixels = 1024;
  const Result<std::shared_ptr<BodyBackend>> body = upload_model(*gpu, s.model);
  if (!body) return state.SkipWithError(body.error().message.c_str());
  (*body)->upload_state(s.model, s.state);
  const std::unique_ptr<VolumeBackend> volume = volume_on(*gpu);
  for (auto _ : state) {
    const auto now = (*body)->resample(Exec(1), s.model, s.state.cuts, s.ct, s.ct.grid, kAlone);
    if (!now) return state.SkipWithError("not enough memory for the deformed CT");
    if (!state.range(0)) continue;  // the CT alone
    if (const Status snapshot = volume->show(now->samples->data(), s.ct.grid); !snapshot)
      return state.SkipWithError(snapshot.error().message.c_str());
    benchmark::DoNotOptimize(volume->draw("skin", s.camera, pixels, pixels).value().pixels.data());
  }
  state.counters["frames/s"] = benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(bench_gpu)->Arg(0)->Arg(1)->ArgName("picture")->Unit(benchmark::kMillisecond)->UseRealTime();

void bench_cpu(benchmark::State& state) {
  static const Scene s = make_scene(256);
  const int pixels = 512;
  const Exec exec(2);
  for (auto _ : state) {
    const CtVolume now = resample_ct(exec, s.model, s.state, s.ct, s.ct.grid, kAlone).ct;
    if (!state.range(0)) continue;
    benchmark::DoNotOptimize(draw_volume(exec, now, "skin", s.camera, pixels, pixels).pixels.data());
  }
  state.counters["frames/s"] = benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(bench_cpu)->Arg(0)->Arg(1)->ArgName("picture")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();

// Cost of a texture in a haptic tick: rhombus chains, finite elements and the contact plane of a lattice, on
// a smooth surface, on waves and on a map of heights.
#include "turgor/contact/texture.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include "turgor/contact/local_contact.hpp"
#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/contact/sfem_touch.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/phantom_liver.hpp"

namespace turgor::contact {
namespace {

constexpr double kTick = 1e-3, kRadius = 5e-3, kStep = 5e-5;  // 50 mm/s
constexpr int kSteps = 200;

/// 0: smooth, 1: waves, 2: a map.
Texture texture_of(std::int64_t kind) {
  if (kind == 0) return {};
  if (kind == 1) return {.waves = {2e-6, 1e-3}};
  std::vector<double> height(256 * 256);
  for (std::size_t i = 0; i < height.size(); i++) height[i] = 2e-6 * std::sin(double(i * i % 1009));
  return {.waves = {}, .map = std::make_shared<const HeightMap>(make_height_map(256, 256, 1e-3, height))};
}
/// Position along x of a tool that slides to and fro [m].
double path_at(long tick) { return kStep * std::abs(double(tick % (2 * kSteps)) - kSteps); }

void chains(benchmark::State& bench) {
  const TriMesh mesh = phantom_liver();
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  const rhombus::Model model = *rhombus::build(std::move(body), {});
  const rhombus::FootPoint foot = rhombus::find_foot_point(model.surface, model.tree, {-0.05, 0.01, 0.2});
  const Vec3d start = foot.at.position + foot.normal * (kRadius - 8e-3);
  RhombusTouch touch = make_rhombus_touch({rhombus_tip(Sphere{kRadius}, {})}, std::vector<Pose>{{start, {}}},
                                          {}, texture_of(bench.range(0)));
  std::vector<ToolReading> reading(1);
  for (auto _ : bench) {
    const std::vector<ToolCommand> command{{{start + Vec3d{path_at(touch.ticks), 0, 0}, {}}}};
    tick_rhombus_touch(model, touch, command, kTick, reading);
    benchmark::DoNotOptimize(reading[0]);
  }
  bench.counters["force_mN"] = 1e3 * touch.textures[0].largest_force;
}

void elements(benchmark::State& bench) {
  sfem::Body body;
  body.mesh = hex_block({60e-3, 60e-3, 30e-3}, {12, 12, 6});
  for (Vec3d& x : body.mesh.vertices) x += Vec3d{-30e-3, -30e-3, -30e-3};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < -29.9e-3);
  body.materials = {{5e3, 0.4}};
  sfem::Model model = *sfem::build(Exec(1), std::move(body), {.touch_depth = 0.02});
  if (!sfem::compute_green(Exec(1), model, std::size_t(1) << 30)) return bench.SkipWithError("no functions");
  const std::vector<Vec3d> at{{0, 0, 0}};
  auto patch = std::make_shared<const sfem::Patch>(
      *sfem::build_patch(model, sfem::patch_elements(model, at, 0.016), 2, at));
  SfemTouch touch =
      make_sfem_touch(std::move(patch), {{Sphere{kRadius}, 0.1}}, std::vector<Pose>{{{0, 0, kRadius}, {}}},
                      {.touch = {},
                       .follow = {},
                       .vertex_count = model.body.mesh.vertices.size(),
                       .texture = texture_of(bench.range(0))});
  std::vector<ToolReading> reading(1);
  for (auto _ : bench) {
    const double depth = 2e-3 * std::min(1.0, double(touch.ticks) / 100);
    const std::vector<ToolCommand> command{{{{path_at(touch.ticks), 1e-3, kRadius - depth}, {}}}};
    tick_sfem_touch(touch, command, kTick, reading);
    benchmark::DoNotOptimize(reading[0]);
  }
  bench.counters["force_mN"] = 1e3 * touch.textures[0].largest_force;
}

void planes(benchmark::State& bench) {
  const Texture texture = texture_of(bench.range(0));
  LocalTouch touch{.params = {}, .map = texture.map};
  update_contact(touch, {.is_near = true,
                         .origin = {},
                         .force = {0, 0, 0.3},
                         .stiffness = 300,
                         .shear_stiffness = 200,
                         .friction = 0.3,
                         .reach = 0.1,
                         .waves = texture.waves});
  ToolReading reading;
  long tick = 0;
  for (auto _ : bench) {
    tick_local_touch(touch, {.pose = {{path_at(tick++), 0, 0}, {}}}, kTick, reading);
    benchmark::DoNotOptimize(reading);
  }
  bench.counters["force_mN"] = 1e3 * touch.texture.largest_force;
}

BENCHMARK(chains)->DenseRange(0, 2)->ArgName("texture")->Unit(benchmark::kNanosecond);
BENCHMARK(elements)->DenseRange(0, 2)->ArgName("texture")->Unit(benchmark::kNanosecond);
BENCHMARK(planes)->DenseRange(0, 2)->ArgName("texture")->Unit(benchmark::kNanosecond);

}  // namespace
}  // namespace turgor::contact

BENCHMARK_MAIN();

// Nonlinear patch under a ball: time of one solution (Newton steps, tangent, compliance of the points) and of
// a tick that uses it; and a live run with a virtual device, whose haptic thread ticks at 1 kHz while a
// thread of its own solves the patch. The goals are 100 solutions of 100 nodes a second, and ticks of 0.3 ms
// beside them.
#include <cmath>
#include <string>

#include <benchmark/benchmark.h>

#include "turgor/contact/patch_follow.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/nonlinear_patch.hpp"
#include "turgor/sim/live/live_run.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

constexpr double kBall = 0.01;  // radius [m]

/// A block of tetrahedra under a ball, and its nonlinear patch.
struct Pressed {
  sfem::Model model;
  sfem::NonlinearPatch nonlinear;
  sfem::Patch patch;
  contact::TouchState state;
  std::vector<contact::Tool> tools{{contact::Sphere{kBall}, 0.3}};
  std::vector<contact::ToolForce> forces{1};

  Pressed(double radius, int refinement) {
    const SolidMesh hexahedra = hex_block({0.06, 0.06, 0.03}, {8, 8, 4});
    sfem::Body body{.mesh = tetrahedralize(hexahedra), .materials = {{5e3, 0.45}}};
    for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < 1e-9);
    model = sfem::build(Exec(2), std::move(body), {.touch_depth = 0.03}).value();
    if (!sfem::compute_green(Exec(2), model, std::size_t(4e9))) return;
    const std::vector<Vec3d> touch{{0.03, 0.03, 0.03}};
    const std::vector<int> elements = sfem::patch_elements(model, touch, radius);
    const sfem::Patch linear = sfem::build_patch(model, elements, refinement, touch).value();
    nonlinear = sfem::make_nonlinear_patch(model, linear, refinement, {3}).value();
    patch = sfem::solve_nonlinear(nonlinear, std::vector<double>(3 * linear.points.size()), 1).value();
    state = contact::make_touch_state(patch, 1, {.capacity = 48});
  }
  void tick(double depth) {
    const std::vector<contact::ToolPose> poses{{{{0.03, 0.03, 0.03 + kBall - depth}, {}}, false}};
    contact::solve_touch_tick(patch, state, tools, poses, 1e-3, forces);
  }
  sfem::NonlinearReport solve() {
    std::vector<double> f;
    for (const Vec3d x : state.force) f.insert(f.end(), {x.x, x.y, x.z});
    sfem::NonlinearReport report;
    sfem::Patch next = sfem::solve_nonlinear(nonlinear, f, 3, &report).value();
    contact::take_patch(state, patch, next, tools);
    patch = std::move(next);
    return report;
  }
};

/// The ball goes 4 mm in and out at 20 mm/s; a solution every eight ticks.
double depth_at(int tick) { return 0.002 * (1 - std::cos(2 * 3.14159265 * tick / 400.0)); }

void solve(benchmark::State& s) {
  Pressed pressed(1e-3 * double(s.range(0)), int(s.range(1)));
  int tick = 100, steps = 0, solutions = 0;
  for (auto _ : s) {
    s.PauseTiming();
    for (int i = 0; i < 8; i++) pressed.tick(depth_at(tick++));
    s.ResumeTiming();
    steps += pressed.solve().steps, solutions++;
  }
  s.counters["nodes"] = double(pressed.nonlinear.u.size() / 3);
  s.counters["points"] = double(pressed.patch.points.size());
  s.counters["steps"] = double(steps) / solutions;
  s.counters["strain"] = pressed.solve().strain;
}
BENCHMARK(solve)->Args({8, 2})->Args({10, 3})->Args({14, 2})->Args({14, 3})->Unit(benchmark::kMillisecond);

void tick(benchmark::State& s) {
  Pressed pressed(1e-3 * double(s.range(0)), int(s.range(1)));
  int tick = 100;
  for (auto _ : s) {
    pressed.tick(depth_at(tick++));
    if (tick % 8 == 0) {
      s.PauseTiming();
      pressed.solve();
      s.ResumeTiming();
    }
  }
  s.counters["nodes"] = double(pressed.nonlinear.u.size() / 3);
}
BENCHMARK(tick)->Args({10, 3})->Args({14, 2})->Unit(benchmark::kMicrosecond);

/// A finger presses a pad for two seconds, held by a simulated hand.
std::string live_text(long frame_rate) {
  return "[world]\nduration = 2\nframe_rate = " + std::to_string(frame_rate) +
         "\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.03], count = [8, 8, 4] }\n"
         "fixed = \"bottom\"\nyoung = 5e3\npoisson = 0.45\ncache = false\nelements = \"linear\"\n"
         "law = \"exponential\"\nstiffening = 3\npatch = { radius = 0.01, refinement = 3 }\n"
         "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.01 }\n"
         "press = { at_fraction = [0.5, 0.5, 1], depth = 0.004, start = 0, duration = 1, hold = 0, times = 1 "
         "}\n";
}
/// Rate of the solutions that ticks used, in the second in which the finger presses.
double solutions_a_second(const HapticRecording& run) {
  constexpr double kBegin = 0.5, kEnd = 1.5;
  int count = 0;
  std::int32_t before = 0;
  for (const HapticTick& tick : run.tools[0].ticks) {
    const std::int32_t now = tick.inputs_used.solution;
    count += now > 0 && now != before && tick.time >= kBegin && tick.time < kEnd;
    before = now;
  }
  return count / (kEnd - kBegin);
}
void live(benchmark::State& s) {
  for (auto _ : s) {
    const Result<Scene> scene = parse_scene(live_text(s.range(0)), "pad.toml", {});
    if (!scene) return s.SkipWithError(scene.error().message.c_str());
    Result<World> world = load_world(Exec(2), *scene);
    if (!world) return s.SkipWithError(world.error().message.c_str());
    Result<LiveRun> run = start_live(*world, {}, 2);
    if (!run) return s.SkipWithError(run.error().message.c_str());
    const int frames = frame_count(*scene);
    for (int n = 0; n < frames && step(Exec(1), *world); n++) {
      run->touch->record_frame_inputs();
      (void)run->touch->wait_for_frame();
    }
    run->touch->stop();
    const Result<HapticRecording> recording = run->touch->haptic_recording();
    if (!recording) return s.SkipWithError(recording.error().message.c_str());
    const haptics::TimingReport& timing = run->touch->timing();
    const SfemBody& body = world->sfem_bodies[0];
    s.counters["nodes"] = body.nonlinear ? double(body.nonlinear->u.size() / 3) : 0;
    s.counters["solutions_a_second"] = solutions_a_second(*recording);
    s.counters["solution_ms"] = 1e3 * body.law_summary.seconds / double(body.law_summary.solutions);
    s.counters["unconverged"] = double(body.law_summary.unconverged) / double(body.law_summary.solutions);
    s.counters["tick_us"] = 1e6 * timing.compute.p50;
    s.counters["tick_p99_us"] = 1e6 * timing.compute.p99;
    s.counters["missed"] = double(timing.missed);
  }
}
BENCHMARK(live)->Arg(30)->Arg(60)->Arg(120)->ArgName("frame_rate")->Iterations(1)->UseRealTime();

}  // namespace
}  // namespace turgor

BENCHMARK_MAIN();

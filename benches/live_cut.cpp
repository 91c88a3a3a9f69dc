// Cut of 70 mm in a live world, drawn by hand: wall time of a frame while the blade moves and after, and of
// the drawn surface. The cut is the same in every body, so twice the body should cost the same for the cut
// itself. TURGOR_BENCH_CT = a CT file replaces the phantoms. The processor times of all threads (cpu_ms)
// depend less on other work of the machine: frames while the blade moves, the twenty frames after it, in
// which nearly all rows are awake, and pictures.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include "turgor/core/timing.hpp"
#include "turgor/sim/live/mouse_tools.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/live/session.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"

namespace {

using namespace turgor;

constexpr double kBladeSeconds = 0.35;  // of 70 mm at the window's 0.2 m/s [s]

/// Torso of this many voxels of 0.78 × 0.78 × 1 mm with elements of 6 mm, or the CT of the environment.
std::string scene_text(Int3 voxels) {
  const char* file = std::getenv("TURGOR_BENCH_CT");
  const std::string ct =
      file ? fmt::format("\"{}\"", file)
           : fmt::format("{{ phantom = \"torso\", size = [{}, {}, {}], spacing_mm = [0.78, 0.78, 1.0] }}",
                         voxels.x, voxels.y, voxels.z);
  return "[world]\nduration = 2\n[body.torso]\nmodel = \"lattice\"\nct = " + ct +
         "\nspacing = 0.006\nfixed = [\"bone\", \"ends\"]\nskin = { tension = 45, stiffness = 300 }\n"
         "solver = { sleep_speed = 3e-4 }\n";
}

/// Curve of 70 mm along the body, as a hand draws it.
CutRequest hand_drawn(const LatticeBody& body) {
  constexpr int kPoints = 8;
  lattice::Incision middle{.from = {0.5, 0, 0.55}, .to = {0.5, 0, 0.5}};
  const Vec3d start = blade_from_fractions(body.model, middle).from;
  CutRequest request{.blade = {.name = "hand", .depth = 0.01, .duration = kBladeSeconds}, .body = 0};
  for (int n = 0; n < kPoints; n++) {
    const double s = double(n) / (kPoints - 1);
    request.blade.path.push_back(start + Vec3d{0.004 * std::sin(5 * s), 0, -0.07 * s});
  }
  request.blade.from = request.blade.path.front(), request.blade.to = request.blade.path.back();
  return request;
}

/// Processor time of all threads of the process [s].
double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

struct FrameTimes {
  std::vector<double> steps, shows;          // wall time [s]
  std::vector<double> step_cpus, show_cpus;  // processor time [s]

  void add(const Exec& exec, World& world, WorldSnapshot& snapshot) {
    const double begin = processor_seconds();
    const Timer stepping;
    benchmark::DoNotOptimize(step(exec, world).value().seconds);
    steps.push_back(stepping.seconds());
    const double middle = processor_seconds();
    const Timer showing;
    show(exec, world, snapshot);
    shows.push_back(showing.seconds());
    step_cpus.push_back(middle - begin), show_cpus.push_back(processor_seconds() - middle);
  }
};

/// Mean of the first values [ms].
double mean_milliseconds(const std::vector<double>& seconds, std::size_t most) {
  const std::size_t count = std::min(most, seconds.size());
  double sum = 0;
  for (std::size_t n = 0; n < count; n++) sum += seconds[n];
  return 1e3 * sum / double(count);
}

double milliseconds(std::vector<double> seconds, double quantile) {
  std::sort(seconds.begin(), seconds.end());
  return 1e3 * seconds[std::size_t(quantile * double(seconds.size() - 1))];
}

/// Largest displacement of the drawn surface [mm]: the opening of the wound.
double opening(const WorldSnapshot& snapshot) {
  float most = 0;
  for (const Vec3 u : snapshot.bodies[0].displacement) most = std::max(most, norm(u));
  return 1e3 * double(most);
}

void bench_cut_frames(benchmark::State& state) {
  const Exec exec(int(state.range(2)));
  const Int3 voxels{int(state.range(0)), int(state.range(0)) * 4 / 5, int(state.range(1))};
  const Scene scene = with_mouse_tools(parse_scene(scene_text(voxels), "bench.toml").value());
  for (auto _ : state) {
    // world at rest
    World world = load_world(exec, scene).value();
    WorldSnapshot snapshot;
    FrameTimes before, during, after;
    for (int frame = 0; frame < 30; frame++) before.add(exec, world, snapshot);

    // cut
    auto kept = std::make_shared<const Scene>(scene);
    const Timer laying;
    if (!apply_request(exec, hand_drawn(world.lattice_bodies[0]), kept, world)) state.SkipWithError("no cut");
    const double lay = laying.seconds();
    const Timer cutting;
    const auto frames = int(std::ceil(kBladeSeconds / world.dt));
    for (int frame = 0; frame <= frames; frame++) during.add(exec, world, snapshot);
    state.SetIterationTime(cutting.seconds());

    // open wound
    for (int frame = 0; frame < 120; frame++) after.add(exec, world, snapshot);
    state.counters["nodes"] = world.lattice_bodies[0].model.anatomy.body_nodes;
    state.counters["vertices"] = double(snapshot.bodies[0].x.size());
    state.counters["lay_ms"] = 1e3 * lay;
    state.counters["rest_ms"] = milliseconds(before.steps, 0.5);
    state.counters["cut_ms"] = milliseconds(during.steps, 0.5);
    state.counters["cut_most_ms"] = milliseconds(during.steps, 1);
    state.counters["cut_show_ms"] = milliseconds(during.shows, 0.5);
    state.counters["after_ms"] = milliseconds(after.steps, 0.5);
    state.counters["after_show_ms"] = milliseconds(after.shows, 0.5);
    state.counters["cut_cpu_ms"] = mean_milliseconds(during.step_cpus, during.step_cpus.size());
    state.counters["after_cpu_ms"] = mean_milliseconds(after.step_cpus, 20);
    state.counters["show_cpu_ms"] = milliseconds(after.show_cpus, 0.5);
    state.counters["opening_mm"] = opening(snapshot);
    state.counters["edges"] = world.cuts[0].edges;
  }
}
BENCHMARK(bench_cut_frames)
    ->ArgsProduct({{512}, {150, 300}, {1, 2}})
    ->ArgNames({"width", "length", "threads"})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// Reads a session 60 times per second, as a window does, and counts new snapshots.
struct Watcher {
  Session& session;
  int snapshots = 0, frame = -1;

  /// Reads until the condition holds, at most `longest` [s]. Returns the wall time [s].
  template <class Condition>
  double read_until(const Condition& condition, double longest) {
    const Timer timer;
    for (; timer.seconds() < longest; std::this_thread::sleep_for(std::chrono::milliseconds(16))) {
      const SessionStatus& now = session.now();
      if (now.snapshot.frame != frame) snapshots++, frame = now.snapshot.frame;
      if (condition(now)) break;
    }
    return timer.seconds();
  }
};

/// Wall time of some seconds of the simulation in a session [s].
struct Paced {
  double pace = 0, snapshots = 0;  // [simulated s/s], [1/s]
};
Paced pace_of(Watcher& watcher, double simulated) {
  const double begin = watcher.session.now().snapshot.time;
  watcher.snapshots = 0;
  const double wall = watcher.read_until(
      [&](const SessionStatus& now) { return now.snapshot.time >= begin + simulated; }, 60);
  return {(watcher.session.now().snapshot.time - begin) / wall, watcher.snapshots / wall};
}

void bench_cut_session(benchmark::State& state) {
  const Int3 voxels{int(state.range(0)), int(state.range(0)) * 4 / 5, int(state.range(1))};
  const auto file = std::filesystem::temp_directory_path() / fmt::format("turgor-bench-{}.toml", getpid());
  std::ofstream(file) << scene_text(voxels);
  const Scene scene = read_scene(file).value();
  for (auto _ : state) {
    const CutRequest request = hand_drawn(load_world(Exec(2), scene).value().lattice_bodies[0]);
    Session session(file, {}, {.threads = int(state.range(2)), .loop = {}, .longest = 600});
    Watcher watcher{session};
    watcher.read_until([](const SessionStatus& now) { return now.snapshot.frame > 30; }, 300);

    // blade
    const std::uint64_t ticks = session.now().haptics.ticks;
    session.request(request);
    const Timer timer;
    watcher.read_until([](const SessionStatus& now) { return !now.cuts.empty(); }, 10);
    const Paced during = pace_of(watcher, kBladeSeconds);
    state.SetIterationTime(timer.seconds());

    // open wound
    const Paced after = pace_of(watcher, 2);
    const double open = opening(session.now().snapshot);
    const double wall = timer.seconds();
    state.counters["ticks/s"] = double(session.now().haptics.ticks - ticks) / wall;
    pace_of(watcher, 4);
    state.counters["pace_cut"] = during.pace, state.counters["pace_after"] = after.pace;
    state.counters["shown_cut/s"] = during.snapshots, state.counters["shown_after/s"] = after.snapshots;
    state.counters["open_2s"] = open / opening(session.now().snapshot);
  }
  std::filesystem::remove(file);
}
BENCHMARK(bench_cut_session)
    ->ArgsProduct({{512}, {150, 300}, {2}})
    ->ArgNames({"width", "length", "threads"})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();

#include "app/check_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include <sys/resource.h>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/amount.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr double kMostSeconds = 2;  // for the frames that are measured [s]

/// Peak resident memory of this process [bytes].
double memory_taken() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * double(usage.ru_maxrss);
}

/// Wall time of one frame [s].
double step_seconds(const Exec& exec, World& world, bool* finite = nullptr) {
  const Timer one;
  const FrameReport report = required(step(exec, world));
  if (finite != nullptr) *finite = report.finite;
  return one.seconds();
}

/// Wall times of the frames from the first on, until they took kMostSeconds together [s]. Throws Failure if
/// one of them is not finite.
std::vector<double> first_frames(const Exec& exec, int frames, World& world) {
  std::vector<double> seconds;
  const Timer all;
  while (int(seconds.size()) < frames && all.seconds() < kMostSeconds) {
    bool finite = true;
    seconds.push_back(step_seconds(exec, world, &finite));
    if (!finite)
      throw Failure{kNotFinite, fmt::format("frame {} of the scene is not finite", seconds.size())};
  }
  return seconds;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Share of the work around a wound that is left at a time [s]: 1 while a blade moves. Then the tissue comes
/// to rest, and rows of nodes sleep.
double share_awake(const World& world, double time) {
  constexpr double kSettling = 0.5;  // [s]; measured on the shipped scenes
  double share = 0;
  for (const Cut& cut : world.cuts) {
    if (time < cut.blade.start) continue;
    const bool sleeps = world.lattice_bodies[std::size_t(cut.body)].model.params.solver.sleep_speed > 0;
    const double idle = std::max(0.0, time - cut.blade.start - cut.blade.duration);
    share = std::max(share, sleeps ? std::exp(-idle / kSettling) : 1);
  }
  return share;
}

/// Wall time of a frame without wounds, in which rows of nodes may sleep [s]. The world then begins again.
double seconds_without_wounds(const Exec& exec, World& world) {
  const std::vector<Cut> cuts = std::exchange(world.cuts, {});
  const std::vector<Suture> sutures = std::exchange(world.sutures, {});
  double least = step_seconds(exec, world);
  for (int frame = 0; frame < 2; frame++) least = std::min(least, step_seconds(exec, world));
  world.cuts = cuts, world.sutures = sutures, world.frame = 0;
  return least;
}

/// Expected wall time of the frames from `first` on, of a world with cuts [s]. It jumps to a few of them, and
/// steps twice there: a blade that jumps cuts all the way in its first step. `at_rest` is the time of a frame
/// while nothing moves.
double seconds_with_wounds(const Exec& exec, int first, int frames, double at_rest, World& world) {
  constexpr int kMoments = 5;
  double sum = 0, with_wound = at_rest;
  const Timer all;
  for (int m = 0; m < kMoments; m++) {
    const int frame = first + (2 * m + 1) * (frames - first) / (2 * kMoments);
    if (frame >= world.frame && all.seconds() < kMostSeconds) {
      world.frame = frame;
      step_seconds(exec, world);
      with_wound = std::max(with_wound, step_seconds(exec, world));
    }
    sum += at_rest + (with_wound - at_rest) * share_awake(world, frame * world.dt);
  }
  return sum / kMoments * (frames - first);
}

/// Expected wall time of all frames [s]: measured for the first ones, which may be all.
double simulation_seconds(const Exec& exec, const Scene& scene, World& world) {
  const int frames = frame_count(scene);
  const bool jumps = !world.cuts.empty() && world.cloth_bodies.empty();  // cloth cannot jump
  const double at_rest = jumps ? seconds_without_wounds(exec, world) : 0;
  const std::vector<double> first = first_frames(exec, frames, world);
  const double measured = std::accumulate(first.begin(), first.end(), 0.0);
  const int rest = frames - int(first.size());
  if (rest == 0) return measured;
  if (!jumps) return measured + median(first) * rest;
  return measured + seconds_with_wounds(exec, frames - rest, frames, at_rest, world);
}

std::string wall_time(double seconds) { return amount(1e9 * seconds, {"ns", "ns"}); }

void print_bodies(const WorldSnapshot& snapshot) {
  for (const BodySnapshot& body : snapshot.bodies) {
    const Vec3d size = (body.box.high - body.box.low) * 1e3;
    print_plain("  {:<12} {:<8} {:.0f} x {:.0f} x {:.0f} mm, {} surface triangles\n", body.name,
                model_name(body.id.kind), size.x, size.y, size.z, body.triangles.size());
  }
  for (const ToolSnapshot& tool : snapshot.tools)
    print_plain("  {:<12} tool     on {}\n", tool.name, body_snapshot(snapshot, tool.body).name);
}

}  // namespace

void check_scene(const Exec& exec, const Scene& scene) {
  const Timer loading;
  World world = required(load_world(exec, scene));
  const double load = loading.seconds();
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  print_plain("{}: valid\n", scene.file.string());
  print_bodies(snapshot);
  std::vector<std::string> plausibility_warnings = notes_of(world);
  for (std::string& warning : odd_sizes(snapshot)) plausibility_warnings.push_back(std::move(warning));
  const double simulating = simulation_seconds(exec, scene, world);
  const int frames = frame_count(scene);
  print_plain("  loading      {}\n", wall_time(load));
  print_plain("  memory       {}\n", amount(memory_taken(), {"bytes", "bytes"}));
  print_plain("  simulating   {} frames of about {}: about {}, and pictures\n", frames,
              wall_time(simulating / std::max(frames, 1)), wall_time(simulating));
  for (const std::string& warning : plausibility_warnings) print_plain("warning: {}\n", warning);
}

}  // namespace turgor

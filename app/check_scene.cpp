#include "app/check_scene.hpp"

#include <algorithm>
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

constexpr int kMostFrames = 10;     // at most, to time a run
constexpr double kMostSeconds = 3;  // limit for these frames [s]

/// Peak resident memory of this process [bytes].
double memory_taken() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * double(usage.ru_maxrss);
}

/// Median wall time of the first frames [s].
double frame_seconds(const Exec& exec, const Scene& scene, World& world) {
  std::vector<double> seconds;
  const Timer all;
  for (int f = 0; f < std::min(kMostFrames, frame_count(scene)) && all.seconds() < kMostSeconds; f++) {
    const Timer one;
    required(step(exec, world));
    seconds.push_back(one.seconds());
  }
  if (seconds.empty()) return 0;
  std::nth_element(seconds.begin(), seconds.begin() + std::ptrdiff_t(seconds.size() / 2), seconds.end());
  return seconds[seconds.size() / 2];
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
  const double frame = frame_seconds(exec, scene, world);
  const int frames = frame_count(scene);
  print_plain("  loading      {}\n", wall_time(load));
  print_plain("  memory       {}\n", amount(memory_taken(), {"bytes", "bytes"}));
  print_plain("  simulating   {} frames of about {}: about {}, and pictures\n", frames, wall_time(frame),
              wall_time(frame * frames));
  for (const std::string& warning : plausibility_warnings) print_plain("warning: {}\n", warning);
}

}  // namespace turgor

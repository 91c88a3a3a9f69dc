// Soak test of the haptic loop: clock drift, memory growth, and missed ticks compared with an empty loop.
#include <algorithm>
#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/empty_loop.hpp"
#include "app/haptic_loops.hpp"
#include "app/print.hpp"
#include "turgor/sim/live/live_run.hpp"
#include "turgor/sim/tools/press_path.hpp"

namespace turgor {

namespace {

constexpr const char* kScene = R"([world]
duration = 1
[body.liver]
model = "rhombus"
surface = { phantom = "liver" }
[tool.tip]
body = "liver"
shape = { sphere = 0.005 }
press = { at_fraction = [0.3, 0.5, 1], depth = 0.001, start = 0 }
)";

/// Resident memory of this process [bytes].
double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * double(sysconf(_SC_PAGESIZE));
}

/// Sets the tool path: down to 5 mm and up again, once a second.
void tap(World& world, double seconds) {
  TouchingTool& tool = world.tools[0];
  const SurfaceSample sample = sample_surface(rest_surface(world, tool.body), {0.3, 0.5, 1}, true, 0.01);
  tool.path = {.rows = {}, .smooth = true};
  for (int n = 0; n <= int(2 * seconds) + 2; n++)
    tool.path.rows.push_back(
        {.time = 0.5 * n, .position = sample.point + sample.normal * (n % 2 == 0 ? 0.015 : 0.0)});
}

/// Steps frames in real time until `seconds`.
Status run_frames(World& world, LiveTouch& touch, double seconds, const Progress& progress,
                  HapticSoak& soak) {
  const Exec exec(1);
  const double settled = std::min(10.0, 0.2 * seconds);  // end of the first allocations [s]
  while (time_of(world) < seconds) {
    if (const Result<FrameReport> frame = step(exec, world); !frame) return frame.error();
    touch.wait_for_frame();
    soak.largest_force = std::max(soak.largest_force, norm(touch.haptic()[0].reading.force));
    if (time_of(world) < settled) soak.resident_before = resident_bytes();
    if (progress && world.frame % 60 == 0) progress(time_of(world) / seconds);
  }
  soak.resident = resident_bytes();
  return Done{};
}

nlohmann::ordered_json to_json(const haptics::TimingReport& r) {
  return {{"ticks", r.ticks},
          {"missed", r.missed},
          {"seconds", r.seconds},
          {"rate_hz", r.rate},
          {"jitter_p50_us", 1e6 * r.jitter.p50},
          {"jitter_p99_us", 1e6 * r.jitter.p99},
          {"jitter_p999_us", 1e6 * r.jitter.p999},
          {"jitter_max_us", 1e6 * r.jitter.largest}};
}

void print_row(const char* name, const haptics::TimingReport& r) {
  print_plain("{:<18}{:>10}{:>9} |{:>8.1f}{:>8.0f}{:>8.0f}{:>9.0f}\n", name, r.ticks, r.missed,
              1e6 * r.jitter.p50, 1e6 * r.jitter.p99, 1e6 * r.jitter.p999, 1e6 * r.jitter.largest);
}

}  // namespace

Result<HapticSoak> soak_haptics(double minutes, const Progress& progress) {
  const double seconds = 60 * minutes;
  const Result<Scene> scene = parse_scene(kScene, "soak.toml");
  if (!scene) return scene.error();
  Result<World> world = load_world(Exec(1), *scene);
  if (!world) return world.error();
  tap(*world, seconds);
  Result<LiveRun> live = start_live(*world, {.longest = 1}, seconds);
  if (!live) return live.error();
  EmptyLoop empty(1000, haptics::LoopParams().priority);
  HapticSoak soak;
  const Status status = run_frames(*world, *live->touch, seconds, progress, soak);
  soak.empty = empty.end();
  live->touch->stop();
  if (!status) return status.error();
  soak.report = live->touch->timing();
  soak.drift = double(soak.report.ticks + soak.report.missed) / soak.report.target_rate - soak.report.seconds;
  soak.frames = live->touch->frames().frames, soak.frames_late = live->touch->frames().late;
  soak.notes = live->touch->notes();
  return soak;
}

void print(const HapticSoak& soak) {
  print_plain("{:<18}{:>10}{:>9} |{:>8}{:>8}{:>8}{:>9}   [us]\n", "", "ticks", "missed", "jitter", "99 %",
              "99.9 %", "max");
  print_row("touched liver", soak.report);
  print_row("empty loop", soak.empty);
  print_plain(
      "\nafter {:.0f} s: drift {:.2f} ms, memory {:.1f} MB ({:+.2f} MB since startup), {} of {} frames "
      "late, largest force {:.2f} N\n",
      soak.report.seconds, 1e3 * soak.drift, 1e-6 * soak.resident,
      1e-6 * (soak.resident - soak.resident_before), soak.frames_late, soak.frames, soak.largest_force);
  for (const std::string& note : soak.notes) print_plain("  {}\n", note);
}

std::string to_json_text(const HapticSoak& soak) {
  const nlohmann::ordered_json json{{"bench", "haptics soak"},
                                    {"haptic", to_json(soak.report)},
                                    {"empty", to_json(soak.empty)},
                                    {"drift_ms", 1e3 * soak.drift},
                                    {"resident_settled_bytes", soak.resident_before},
                                    {"resident_bytes", soak.resident},
                                    {"frames", soak.frames},
                                    {"frames_late", soak.frames_late},
                                    {"force_max_n", soak.largest_force},
                                    {"notes", soak.notes}};
  return json.dump(2) + "\n";
}

}  // namespace turgor

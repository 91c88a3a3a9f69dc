// Pace of a window while a cut is drawn by hand, and in ordinary scenes, against the goals of the project on
// two cores with software rendering. One command, at most five minutes on a quiet machine:
//   xvfb-run -a -s "-screen 0 1280x1024x24 -noreset" build/release/benches/bench_live_goals [CT…]
// Processor times (frames, with the snapshots that the session's threads make; pictures) depend less on other
// work of the machine than paces do. A `CT` is a patient's CT (a file or a DICOM folder) and adds a row. The
// program returns 1 if a goal is missed.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

#include "benches/thread_times.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/window/window.hpp"

namespace {

using namespace turgor;
namespace fs = std::filesystem;

constexpr double kCut = 0.5, kAfter = 0.9, kPictures = 15, kOpenShare = 0.9;  // [1], [1], [1/s], [1]
constexpr double kLength = 0.07, kBladeSpeed = 0.2;                           // of the cut [m], [m/s]

/// A torso with elements of 6 mm.
std::string torso_text(const std::string& ct) {
  return "[world]\nduration = 60\n[body.torso]\nmodel = \"lattice\"\nct = " + ct +
         "\nspacing = 0.006\nfixed = [\"bone\", \"ends\"]\nskin = { tension = 45, stiffness = 300 }\n"
         "solver = { sleep_speed = 3e-4 }\n";
}

/// A window with its scene. Counts pictures that showed a new state, and measures the longest time between
/// two.
struct Watched {
  std::unique_ptr<SceneWindow> window;
  int pictures = 0, frame = -1;
  Timer since_picture;
  double longest_gap = 0;  // [s]

  /// Starts new counts at the present picture.
  void restart() { pictures = 0, longest_gap = 0, since_picture = Timer(); }

  /// Counts the picture that was just drawn, if its state is new.
  void count_picture() {
    if (now().snapshot.frame == frame) return;
    pictures++, frame = now().snapshot.frame;
    longest_gap = std::max(longest_gap, since_picture.seconds());
    since_picture = Timer();
  }

  const SessionStatus& now() { return *window->viewer().now; }

  /// Draws until the condition holds, at most `longest` [s]. False: it does not hold yet.
  template <class Condition>
  bool draw_until(const Condition& condition, double longest) {
    for (const Timer timer; timer.seconds() < longest;) {
      if (!window->draw()) return false;
      count_picture();
      if (now().phase == SessionStatus::Phase::kFailed) return false;
      if (condition(now())) return true;
    }
    return false;
  }
};

/// Pace, pictures and processor times of a part of a run.
struct Paced {
  double pace = 0, pictures = 0;       // [simulated s/s], [1/s]
  double gap = 0;                      // longest time between two new pictures [s]
  double frame = 0, picture = 0;       // processor time of the session a frame, and of drawing a picture [s]
  double rasterizer = 0, haptics = 0;  // included in `picture` [s]; fraction of a core [1]
};

/// Draws until a condition holds and measures meanwhile.
template <class Condition>
Paced pace_until(Watched& watched, const Condition& condition, double longest) {
  const WorldSnapshot& before = watched.now().snapshot;
  const double begin = before.time;
  const int frame = before.frame;
  const std::map<std::string, double> times = thread_times();
  watched.restart();
  const Timer timer;
  watched.draw_until(condition, longest);
  const double seconds = timer.seconds();
  std::map<std::string, double> used = thread_times();
  for (const auto& [name, time] : times) used[name] -= time;
  const double frames = std::max(1, watched.now().snapshot.frame - frame),
               pictures = std::max(1, watched.pictures);
  return {.pace = (watched.now().snapshot.time - begin) / seconds,
          .pictures = watched.pictures / seconds,
          .gap = std::max(watched.longest_gap, watched.since_picture.seconds()),
          .frame = used["session"] / frames,
          .picture = (used["main"] + used["llvmpipe"]) / pictures,
          .rasterizer = used["llvmpipe"] / pictures,
          .haptics = used["haptic loop"] / seconds};
}
Paced pace_of(Watched& watched, double simulated, double longest) {
  const double end = watched.now().snapshot.time + simulated;
  return pace_until(
      watched, [=](const SessionStatus& now) { return now.snapshot.time >= end; }, longest);
}

Watched open(const fs::path& scene) {
  WindowOptions options{.scene = scene, .overrides = {}, .out = fs::temp_directory_path()};
  options.width = 1280, options.height = 800;
  options.session.threads = 2;
  Result<std::unique_ptr<SceneWindow>> window = SceneWindow::open(options);
  if (!window) {
    std::fprintf(stderr, "bench_live_goals: %s\n", window.error().message.c_str());
    std::exit(2);
  }
  Watched watched{std::move(*window)};
  const auto runs = [](const SessionStatus& now) {
    return now.phase == SessionStatus::Phase::kReady && now.snapshot.frame > 30;
  };
  if (!watched.draw_until(runs, 120)) {
    std::fprintf(stderr, "bench_live_goals: %s: %s\n", scene.c_str(),
                 watched.now().error.empty() ? "not loaded after 120 s" : watched.now().error.c_str());
    std::exit(2);
  }
  return watched;
}

/// Curve on the front of the first body, as a hand draws it: from head to feet, or across a body that is
/// too short for it.
std::optional<CutRequest> hand_drawn(const WorldSnapshot& snapshot) {
  constexpr int kPoints = 8;
  const Box box = snapshot.bodies[0].box;
  const Vec3d middle = (box.low + box.high) * 0.5;
  const Vec3d size = box.high - box.low;
  const bool is_across = 0.6 * size.z < kLength;
  const double length = std::min(kLength, 0.6 * (is_across ? size.x : size.z));
  CutRequest request{.blade = {.name = "hand", .depth = 0.01, .duration = length / kBladeSpeed}, .body = 0};
  for (int n = 0; n < kPoints; n++) {
    const double s = double(n) / (kPoints - 1);
    const double along = (0.5 - s) * length, aside = 0.004 * std::sin(5 * s);
    const Vec3d eye{middle.x + (is_across ? along : aside), box.low.y - 1,
                    middle.z + (is_across ? aside : along)};
    const std::optional<Picked> skin = pick(snapshot, {eye, {0, 1, 0}});
    if (!skin) return std::nullopt;
    request.blade.path.push_back(skin->point);
  }
  request.blade.from = request.blade.path.front(), request.blade.to = request.blade.path.back();
  return request;
}

/// Largest displacement of the drawn surface [mm]: the opening of the wound.
double opening(const WorldSnapshot& snapshot) {
  float most = 0;
  for (const Vec3 u : snapshot.bodies[0].displacement) most = std::max(most, norm(u));
  return 1e3 * double(most);
}

struct CutFigures {
  Paced during, after;
  double open_2s = 0, open = 0;  // opening 2 s after the blade and at last [mm]
  std::uint64_t ticks = 0, missed = 0;
};

std::optional<CutFigures> cut_by_hand(const fs::path& scene) {
  Watched watched = open(scene);
  const std::optional<CutRequest> request = hand_drawn(watched.now().snapshot);
  if (!request) return std::nullopt;
  const haptics::TimingReport before = watched.now().haptics;
  CutFigures figures;
  watched.window->viewer().session.request(*request);
  watched.draw_until([](const SessionStatus& now) { return now.cut_result.cut >= 0; }, 10);
  figures.during = pace_until(
      watched, [](const SessionStatus& now) { return now.cut_result.done >= 1 || !now.error.empty(); }, 60);
  if (watched.now().cut_result.done < 1) return std::nullopt;

  // two seconds of the clock, then until the wound is at rest
  figures.after = pace_until(
      watched, [](const SessionStatus&) { return false; }, 2);
  figures.open_2s = opening(watched.now().snapshot);
  figures.ticks = watched.now().haptics.ticks - before.ticks;
  figures.missed = watched.now().haptics.missed - before.missed;
  pace_of(watched, 4, 20);
  figures.open = opening(watched.now().snapshot);
  return figures;
}

/// A figure and its goal. Counts misses.
std::string against(double value, double goal, int& misses) {
  const bool is_kept = value >= goal;
  misses += !is_kept;
  return fmt::format("{:6.2f} {}", value, is_kept ? "kept" : "MISS");
}

void print_cut(const std::string& name, const fs::path& scene, int& misses) {
  const std::optional<CutFigures> f = cut_by_hand(scene);
  if (!f) {
    misses++;
    fmt::print("{:<26} the cut could not be made\n", name);
    return;
  }
  fmt::print("{:<26} {} {} {} {} {}   {:>6} of {}; opened {:.1f} mm\n", name,
             against(f->during.pace, kCut, misses), against(f->after.pace, kAfter, misses),
             against(f->open > 0 ? f->open_2s / f->open : 0, kOpenShare, misses),
             against(f->during.pictures, kPictures, misses), against(f->after.pictures, kPictures, misses),
             f->missed, f->ticks + f->missed, f->open);
  for (const auto& [when, p] : {std::pair("cutting", f->during), std::pair("after", f->after)})
    fmt::print(
        "  {:<8} processor time {:.1f} ms a frame, {:.1f} ms a picture ({:.1f} of it the rasterizer), "
        "haptic loop {:.1f} % of a core; longest gap between pictures {:.0f} ms\n",
        when, 1e3 * p.frame, 1e3 * p.picture, 1e3 * p.rasterizer, 1e2 * p.haptics, 1e3 * p.gap);
  std::fflush(stdout);
}

void print_scene(const std::string& file, int& misses) {
  const fs::path scene = fs::path(TURGOR_SCENE_FOLDER) / file;
  Watched watched = open(scene);
  const haptics::TimingReport before = watched.now().haptics;
  const Paced paced = pace_until(
      watched, [](const SessionStatus&) { return false; }, 6);
  const std::uint64_t ticks = watched.now().haptics.ticks - before.ticks,
                      missed = watched.now().haptics.missed - before.missed;
  fmt::print("{:<26} {:11} {} {:11} {:11} {}   {:>6} of {}\n", file, "", against(paced.pace, kAfter, misses),
             "", "", against(paced.pictures, kPictures, misses), missed, ticks + missed);
  std::fflush(stdout);
}

std::string phantom(int slices) {
  return fmt::format("{{ phantom = \"torso\", size = [512, 512, {}], spacing_mm = [0.78, 0.78, 1.0] }}",
                     slices);
}

}  // namespace

int main(int count, char** words) {
  const Timer timer;
  const fs::path scene = fs::temp_directory_path() / fmt::format("turgor-live-goals-{}.toml", getpid());
  const auto write = [&scene](const std::string& ct) { std::ofstream(scene) << torso_text(ct); };
  int misses = 0;
  fmt::print(
      "cut of 70 mm by hand; paces in simulated seconds per second, opening 2 s after the blade relative to\n"
      "that after 6 s, pictures with a new state per second, ticks of the haptic loop that were missed\n");
  fmt::print("{:<26} {:<11} {:<11} {:<11} {:<11} {:<11}   {}\n", "", "cutting", "after", "open", "pict. cut",
             "pict. after", "missed ticks");
  fmt::print("{:<26} {:6} {:4} {:6} {:4} {:6} {:4} {:6} {:4} {:6}\n", "goal, at least", kCut, "", kAfter, "",
             kOpenShare, "", kPictures, "", kPictures);
  write(phantom(275)), print_cut("phantom 512x512x275", scene, misses);
  write(phantom(550)), print_cut("phantom 512x512x550", scene, misses);
  for (int n = 1; n < count; n++) {
    const fs::path ct = fs::canonical(words[n]);
    write(fmt::format("\"{}\"", ct.string())), print_cut(ct.filename().string(), scene, misses);
  }
  for (const char* file : {"palpation.toml", "incision.toml", "flag.toml"}) print_scene(file, misses);
  fs::remove(scene);
  fmt::print("{} goals missed; {:.0f} s in all\n", misses, timer.seconds());
  return misses > 0;
}

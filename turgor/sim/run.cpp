#include "turgor/sim/run.hpp"

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/smooth_snapshot.hpp"
#include "turgor/sim/undone_step.hpp"

namespace turgor {

namespace {

/// WorldSnapshot::frame of a snapshot that is filled again.
constexpr int kNotShown = -1;

/// State of a run.
struct Running {
  const Exec& exec;
  const World& world;
  const RunEvents& events;
  Simulated result;
};

/// Fills the snapshot, once per frame.
void show_now(Running& run) {
  if (!run.result.snapshot.bodies.empty() && run.result.snapshot.frame == run.world.frame) return;
  const Timer timer;
  show(run.exec, run.world, run.result.snapshot);
  show_smooth(run.result.snapshot, kMostInPictures, run.exec);
  run.result.show_seconds += timer.seconds();
  note_surface_seconds(run.result.snapshot, run.result.measures.pressed);
}

Status take_snapshot(Running& run) {
  show_now(run);
  return run.events.snapshot ? run.events.snapshot(run.world, run.result.snapshot) : Done{};
}

Status take_picture(Running& run) {
  if (!run.events.picture || !run.events.wants_picture || !run.events.wants_picture(run.world)) return Done{};
  show_now(run);
  return run.events.picture(run.result.snapshot);
}

/// Reason to stop after this frame; empty to continue.
std::string reason_to_stop(const Running& run, const Scene& scene, bool finite) {
  if (!finite)
    return fmt::format(
        "stopped after {:.3f} s of {} s: the next step was not finite, the state before it "
        "was kept; {}",
        time_of(run.world), scene.duration, advice_for_undone_step(run.world));
  if (run.events.frame && !run.events.frame(run.world))
    return fmt::format("stopped after {:.3f} s of {} s, on request", time_of(run.world), scene.duration);
  return {};
}

}  // namespace

Result<Simulated> simulate(const Exec& exec, const Scene& scene, World& world, const RunEvents& events,
                           std::optional<Simulated> resumed, WorldSnapshot shown) {
  // initial state
  Running run{exec, world, events, resumed ? std::move(*resumed) : Simulated()};
  if (!resumed) run.result.snapshot = std::move(shown), run.result.snapshot.frame = kNotShown;
  run.result.snapshot.cutaway = scene.look.cutaway;
  if (!resumed) {
    run.result.measures = make_measures(world);
    if (const Status first = take_snapshot(run); !first) return first.error();
  }
  const int frames = frame_count(scene);
  TURGOR_CHECK(frames >= 1, "a run has at least one frame");
  for (int frame = world.frame + 1; frame <= frames && run.result.stopped.empty(); frame++) {
    // step and measure
    const bool planned = is_snapshot(scene, frame);
    const Result<FrameReport> report = step(exec, world, planned);
    if (!report) return report.error();
    run.result.finite = report->finite;
    measure_frame(exec, world, *report, planned || !report->finite, run.result.measures);

    // pictures and snapshots
    run.result.stopped = reason_to_stop(run, scene, report->finite);
    const bool stops = !run.result.stopped.empty();
    Status status = stops ? Status(Done{}) : take_picture(run);
    if (status && (planned || stops)) status = take_snapshot(run);
    if (status && !stops && events.end_of_frame) status = events.end_of_frame(world, run.result);
    if (!status) return status.error();
    if (events.progress) events.progress(double(frame) / frames);
  }
  return std::move(run.result);
}

}  // namespace turgor

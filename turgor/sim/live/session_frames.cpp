#include "turgor/sim/live/session_frames.hpp"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/live/session_thread.hpp"
#include "turgor/sim/undone_step.hpp"

namespace turgor {

namespace {

/// Error message for a step that was undone.
std::string not_finite(const World& world) {
  return fmt::format("the next step was not finite; the world is paused in its state at {:.3f} s ({})",
                     (world.frame - 1) * world.dt, advice_for_undone_step(world));
}

void pause_with_error(SessionThread& session, const std::string& why) {
  session.next.error = why, session.next.plays = false;
  set_pace(session);
}

/// Name of the material at the tip of a needle; empty outside of its body.
std::string layer_at_tip(const World& world, const TouchingTool& tool, const contact::NeedleReading& needle) {
  if (tool.body.kind != BodyKind::kSfem || !(needle.inserted > 0)) return {};
  const SfemBody& body = world.sfem_bodies[std::size_t(tool.body.index)];
  for (const InnerRegion& region : body.inside)
    if (region.material == needle.material) return region.name;
  return body.name;
}

/// Appends the newest sample of every tool.
void collect_haptic_samples(SessionWorld& live, SessionStatus& next) {
  if (!live.touch) return;
  const std::vector<HapticStatus>& haptic = live.touch->haptic();
  TURGOR_CHECK(haptic.size() == next.haptic.size(), "every tool has a haptic status");
  next.layers.resize(haptic.size());
  for (std::size_t t = 0; t < haptic.size(); t++) {
    next.layers[t] = layer_at_tip(*live.world, live.world->tools[t], haptic[t].needle);
    std::vector<HapticSample>& points = next.haptic[t];
    if (points.size() == SessionStatus::kMaxHapticSamples) points.erase(points.begin());
    points.push_back({time_of(*live.world), norm(haptic[t].reading.force), haptic[t].reading.depth,
                      haptic[t].work, haptic[t].needle});
  }
}

/// Waits until the frame's due time, and measures the pace. Returns the delay [s].
double wait_for_clock(SessionWorld& live, PaceMeter& meter, SessionStatus& next) {
  TURGOR_ASSERT(live.touch != nullptr || live.clock.has_value(), "a world has a clock");
  const double late = live.touch ? live.touch->wait_for_frame() : live.clock->wait(live.world->frame);
  const auto now = std::chrono::steady_clock::now();
  const double passed = std::chrono::duration<double>(now - meter.frame_begun).count();
  meter.frame_begun = now;
  add_to_mean(passed, meter.frame_period);
  next.real_pace = live.world->dt / std::max(meter.frame_period, 1e-6);
  return late;
}

}  // namespace

bool is_playing(const SessionThread& session) { return session.next.plays && session.live.world; }

void play_frame(SessionThread& session) {
  if (!is_playing(session)) return;
  SessionWorld& live = session.live;

  // step
  const Timer timer;
  const Result<FrameReport> report = step(session.exec, *live.world);
  add_to_mean(timer.seconds(), session.next.frame_seconds);
  if (live.touch && report) live.touch->record_frame_inputs();
  if (!report) return pause_with_error(session, report.error().message);
  if (!report->finite) return pause_with_error(session, not_finite(*live.world));

  // samples, then wait for the clock
  collect_haptic_samples(live, session.next);
  add_motion(*live.world, session.ct);
  const double late = wait_for_clock(live, session.meter, session.next);
  constexpr double kForgotten = 0.25;  // larger delays are dropped [s]
  if (late > kForgotten) set_pace(session);
}

void begin_single_step(SessionThread& session) {
  SessionWorld& live = session.live;
  session.due.step = std::chrono::steady_clock::now();
  if (!live.touch) return;

  // let the haptic thread run for one frame
  live.touch->allow(live.world->dt);
  const std::chrono::duration<double> ticks(1.5 * live.world->dt / session.next.pace);
  *session.due.step += std::chrono::duration_cast<std::chrono::steady_clock::duration>(ticks);
}

void step_if_due(SessionThread& session) {
  if (!session.due.step) return;
  session.due.step.reset();
  SessionWorld& live = session.live;
  TURGOR_ASSERT(live.world != nullptr, "a single step needs a world");

  // step
  const Result<FrameReport> report = step(session.exec, *live.world);
  if (live.touch && report) live.touch->record_frame_inputs();
  session.next.error = report ? "" : report.error().message;

  // samples
  collect_haptic_samples(live, session.next);
  add_motion(*live.world, session.ct);
  if (report && !report->finite) session.next.error = not_finite(*live.world);
}

void set_pace(SessionThread& session) {
  if (session.live.touch) session.live.touch->set_pace(session.next.plays ? session.next.pace : 0);
  session.live.clock->set_pace(session.next.pace);
  session.meter.frame_begun = std::chrono::steady_clock::now();
}

}  // namespace turgor

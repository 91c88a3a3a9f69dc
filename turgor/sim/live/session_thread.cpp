#include "turgor/sim/live/session_thread.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/live/handle_requests.hpp"
#include "turgor/sim/smooth_snapshot.hpp"

namespace turgor {

namespace {

/// Cuts made by requests; they follow the scene's cuts in World::cuts.
std::vector<lattice::Incision> interactive_cuts(const Scene& scene, const World& world) {
  std::vector<lattice::Incision> cuts;
  for (std::size_t c = scene.incisions.size(); c < world.cuts.size(); c++) {
    TURGOR_CHECK(is_index(world.cuts[c].body, world.lattice_bodies.size()), "a cut belongs to a lattice");
    cuts.push_back(world.cuts[c].blade);
    cuts.back().name = world.lattice_bodies[std::size_t(world.cuts[c].body)].name;
  }
  return cuts;
}

/// Brings surfaces that tools touch up to the present cuts. Frames without a contact leave them as they were,
/// so that they are made once for a snapshot.
void refresh_surfaces(const Exec& exec, World& world) {
  for (LatticeBody& body : world.lattice_bodies)
    if (!body.tools.empty()) refresh_surface(exec, body);
}

/// Publishes the state. The snapshot is written to the reader's buffer, to reuse its memory.
void publish(SessionThread& session) {
  // state
  SessionStatus& next = session.next;
  SessionWorld& live = session.live;
  const Timer timer;
  const bool shows = live.world && next.phase == SessionStatus::Phase::kReady;
  if (shows) refresh_surfaces(session.exec, *live.world);
  if (live.touch) next.haptics = live.touch->timing();
  if (live.world) next.cuts = interactive_cuts(*session.source.scene, *live.world);
  if (live.world)
    update_cut_result(session.exec, *live.world, session.source.scene->incisions.size(),
                      session.cut_measuring, next.cut_result);
  if (live.world) next.stitches = hand_stitches(*session.source.scene, *live.world);
  next.undo = undo_text(session.history), next.redo = redo_text(session.history);
  next.frames = live.touch ? live.touch->frames() : live.clock ? live.clock->timing() : FrameTiming();

  // copy into the reader's buffer, whose snapshot is kept
  next.number++;
  SessionStatus& out = session.published.writing();
  const bool is_kept = out.world == next.world && out.undone_cuts == next.undone_cuts;
  WorldSnapshot snapshot = is_kept ? std::move(out.snapshot) : WorldSnapshot();
  out = next;
  out.snapshot = std::move(snapshot);

  // snapshot
  if (shows) {
    out.snapshot.cutaway = session.cutaway;
    show(session.exec, *live.world, out.snapshot);
    show_smooth(out.snapshot, kMostInWindow, session.exec);
    add_to_mean(timer.seconds(), next.show_seconds);
  }
  session.published.publish();
  session.rate.published_at = std::chrono::steady_clock::now();
}

/// Publishes the state after a frame, at the rate of SnapshotRate while the world plays.
void publish_frame(SessionThread& session) {
  const auto now = std::chrono::steady_clock::now();
  const bool is_late = session.next.real_pace < 0.9 * session.next.pace;
  if (is_playing(session) && !session.rate.is_due(now, is_late, session.published.has_news())) return;
  session.rate.count(now);
  publish(session);
}

/// Publishes the loading progress, at most twenty times per second. Any loading thread may call it, while the
/// session's thread waits.
void report_progress(SessionThread& session, double done) {
  const std::unique_lock lock(session.progress.mutex, std::try_to_lock);
  const auto now = std::chrono::steady_clock::now();
  if (!lock || now - session.progress.last < std::chrono::milliseconds(50)) return;
  session.progress.last = now, session.next.done = done;
  publish(session);
}

/// Reads the scene and loads its world, with progress reports.
Status load_source(SessionThread& session) {
  // scene
  if (const Status read = read_source(session.source); !read) return read.error();
  session.next.scene = session.source.scene;
  session.record = {session.source.scene, {}};

  // world
  const BeginWork begin = [&session](const std::string& label, const std::string&) -> Progress {
    session.next.doing = label, session.next.done = 0;
    publish(session);
    return [&session](double done) { report_progress(session, done); };
  };
  Result<SessionWorld> loaded =
      load_session_world(session.exec, *session.source.scene, session.params, begin);
  if (!loaded) return loaded.error();
  session.live = std::move(*loaded);

  // state for readers
  session.next.haptic.resize(session.live.world->tools.size());
  session.next.mouse = session.live.mouse, session.next.is_haptic = session.live.touch != nullptr;
  set_pace(session);
  return Done{};
}

/// Replaces the world by that of SessionThread::source.
void load(SessionThread& session) {
  unload(session.live);
  session.ct = {};
  forget_world(session.history);

  // new state, which keeps the pace
  SessionStatus& next = session.next;
  const SessionStatus before = std::move(next);
  next = {.world = before.world + 1,
          .number = before.number,
          .scene = session.source.scene ? before.scene : nullptr,
          .pace = before.pace,
          .plays = before.plays};
  next.doing = "loading " + session.source.file.file.filename().string();
  publish(session);

  // world
  if (const Status status = load_source(session); !status) {
    next.phase = SessionStatus::Phase::kFailed, next.error = status.error().message;
  } else {
    next.phase = SessionStatus::Phase::kReady, next.notes = notes_of(*session.live.world);
  }
  publish(session);
}

void load_if_due(SessionThread& session) {
  if (std::exchange(session.due.load, false)) load(session);
}

void save_if_due(SessionThread& session) {
  if (const auto file = std::exchange(session.due.save, std::nullopt))
    session.next.saved = save_record(session.record, session.live, *file);
}

bool is_batch_done(const SessionThread& session) { return session.batch.empty() && !session.due.step; }

/// Waits for the time of a due single step. Takes the next batch when the present one is done; a paused
/// session waits for a request. Returns false once the session ends.
bool wait(SessionThread& session) {
  if (session.due.step) session.queue.wait_until(*session.due.step);
  if (!is_batch_done(session)) return true;
  return session.queue.take(!is_playing(session), session.batch);
}

}  // namespace

void run_session(SessionThread& session) {
  session.next.plays = session.params.plays;
  if (session.source.file.file.empty())
    session.next.phase = SessionStatus::Phase::kEmpty, publish(session);
  else
    load(session);
  while (wait(session)) {
    step_if_due(session);
    handle_requests(session);
    load_if_due(session);
    save_if_due(session);
    if (!is_batch_done(session)) continue;
    play_frame(session);
    publish_frame(session);
  }
  unload(session.live);
}

}  // namespace turgor

// Thread of a session. Its loop waits, handles requests and plays frames. Handlers only change state. Work
// that waits or takes long is left to the loop (DueWork).
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>

#include "turgor/core/exec.hpp"
#include "turgor/core/latest.hpp"
#include "turgor/sim/live/edit_history.hpp"
#include "turgor/sim/live/session.hpp"
#include "turgor/sim/live/session_ct.hpp"
#include "turgor/sim/live/session_frames.hpp"
#include "turgor/sim/live/session_record.hpp"
#include "turgor/sim/live/session_requests.hpp"
#include "turgor/sim/live/session_world.hpp"
#include "turgor/sim/live/snapshot_rate.hpp"

namespace turgor {

/// Work that a request has left to the loop. Later requests wait until it is done.
struct DueWork {
  bool load = false;                          // load the world of SessionThread::source
  std::optional<std::filesystem::path> save;  // write the haptic recording to this file
  std::optional<std::chrono::steady_clock::time_point>
      step;  // step one frame at this time, when its haptic ticks are done
};

/// Rate limit of progress reports. Any loading thread may report.
struct ProgressReports {
  std::mutex mutex;
  std::chrono::steady_clock::time_point last;
};

struct SessionThread {
  const SessionParams& params;
  RequestQueue& queue;
  latest<SessionStatus>& published;
  Exec exec;
  SessionSource source;
  std::deque<Request> batch = {};  // requests to handle before the next frame
  DueWork due = {};
  SessionWorld live = {};
  SessionRecord record = {};
  EditHistory history = {};
  CutMeasuring cut_measuring = {};
  SessionCt ct = {};
  std::optional<CutawayScene> cutaway = {};  // whose planes have sections of the CT
  PaceMeter meter = {};
  ProgressReports progress = {};
  SnapshotRate rate = {};
  SessionStatus next =
      {};  // state for readers, without the snapshot, which is written directly to the reader's buffer
};

/// Runs the session until its queue ends.
void run_session(SessionThread& session);

}  // namespace turgor

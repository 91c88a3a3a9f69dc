// Requests to a session, and the queue through which other threads send them. The session's thread takes them
// in batches between frames and handles each batch in order.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "turgor/sim/deformed_ct.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/scene/look_scene.hpp"

namespace turgor {

struct PaceRequest {
  bool plays = true;
  double pace = 1;  // above 0
};
struct StepRequest {};    // computes one frame while the session is paused
struct ResetRequest {};   // loads the present scene again
struct ReloadRequest {};  // reads the scene's file again and applies all changed values
struct OpenRequest {      // opens another scene
  std::filesystem::path file;
  std::vector<std::string> overrides;
};
struct CtRequest {  // computes the deformed CT: see SessionStatus::ct
  CtTargets targets;
};
struct CutawayRequest {  // snapshots have sections of the CT in the planes of this cut-away; empty: none
  std::optional<CutawayScene> cutaway;
};
/// Saves a haptic recording of all inputs since the world was loaded (haptic_recording.hpp).
/// SessionStatus::saved has the result.
struct SaveRequest {
  std::filesystem::path file;
};
struct UndoRequest {};  // takes back the latest cut, stitch or change (edit_history.hpp)
struct RedoRequest {};  // repeats what was taken back last
using Request = std::variant<UndoRequest, RedoRequest, PaceRequest, StepRequest, ResetRequest, ReloadRequest,
                             OpenRequest, CutRequest, WindRequest, CtRequest, ChangeRequest, SaveRequest,
                             StitchRequest, TightenRequest, CutawayRequest>;

/// Requests that the session's thread has not taken yet.
class RequestQueue {
 public:
  void push(Request request);
  /// Ends the session after its present work.
  void end();

  /// Session's thread only: moves all requests to `taken`, which must be empty. If `waits` is true, waits for
  /// at least one request. Returns false once the session ends.
  bool take(bool waits, std::deque<Request>& taken);
  /// Session's thread only: waits until this time, or until the session ends.
  void wait_until(std::chrono::steady_clock::time_point time);

 private:
  std::mutex mutex_;  // guards the two members below
  std::deque<Request> requests_;
  bool is_ending_ = false;
  std::condition_variable wake_;
};

}  // namespace turgor

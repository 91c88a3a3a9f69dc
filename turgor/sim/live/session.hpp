// Interactive session: a scene that runs by the clock on its own thread and handles requests (pace, reset,
// reload, cuts, changes). Every touchable body has a tool that a mouse can drive (haptics/mouse_device.hpp),
// with haptic forces at 1 kHz. Readers get complete snapshots through latest<T>; the session never waits for
// them.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "turgor/core/latest.hpp"
#include "turgor/haptics/mouse_device.hpp"
#include "turgor/sim/deformed_ct.hpp"
#include "turgor/sim/live/cut_results.hpp"
#include "turgor/sim/live/live_touch.hpp"
#include "turgor/sim/live/session_requests.hpp"
#include "turgor/sim/live/stitch_results.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// A tool that the mouse can drive.
struct MouseTool {
  int tool = 0;  // index into WorldSnapshot::tools
  std::shared_ptr<haptics::MouseDevice> device;
};

/// Sample of a tool, once per frame.
struct HapticSample {
  double time = 0, force = 0, depth = 0;  // [s] [N] [m]
  double work = 0;                        // net work of the hand on the body [J]
  contact::NeedleReading needle = {};     // of a needle
};

/// State of a session for readers.
struct SessionStatus {
  enum class Phase : std::uint8_t { kLoading, kReady, kFailed, kEmpty };  // empty: no scene was opened yet
  Phase phase = Phase::kLoading;
  int world = 0;  // number of worlds loaded so far; a new number invalidates indices into the previous world
  long number = 0;                     // number of states published so far
  std::string doing;                   // present loading task
  double done = 0;                     // finished fraction of that task, 0 to 1
  std::string error;                   // reason why there is no world, or why it is paused
  std::shared_ptr<const Scene> scene;  // with all changes; null: the file could not be read
  WorldSnapshot snapshot;
  std::vector<MouseTool> mouse;
  std::vector<lattice::Incision> cuts;            // cuts by requests; `name` is that of the cut body
  CutResult cut_result;                           // of the latest of `cuts`
  std::vector<HandStitch> stitches;               // by requests, in their order
  std::vector<std::vector<HapticSample>> haptic;  // of every tool, newest last, at most kMaxHapticSamples
  std::vector<std::string> layers;  // material at the tip of every needle; empty: outside, or another tool
  double pace = 1;                  // requested simulated seconds per second
  bool plays = true;
  double frame_seconds = 0, show_seconds = 0;  // wall times of a frame, running means
  double real_pace = 0;                        // achieved simulated seconds per second
  bool is_haptic = false;                      // true while the haptic loop runs
  haptics::TimingReport haptics;
  FrameTiming frames;
  std::shared_ptr<const DeformedCt>
      ct;  // deformed CT of the first lattice, computed at the latest CtRequest; null: not requested
  std::vector<std::string> notes;  // warnings and notes of loading
  std::string saved;               // message about the latest SaveRequest
  std::string undo, redo;  // cut or change that the next UndoRequest or RedoRequest concerns, or empty
  std::string edited;      // result of the latest UndoRequest or RedoRequest since the world was loaded
  int edits = 0;           // number of these requests
  int undone_cuts = 0;     // cuts that were taken back since the world was loaded

  static constexpr std::size_t kMaxHapticSamples = 900;
  static constexpr int kMostSamples =
      160;  // limit of the samples of `ct` along an axis, when it is computed on the host
};

struct SessionParams {
  int threads = 0;  // number of threads for physics; 0 = one per core
  haptics::LoopParams loop;
  double longest = 3600;  // limit of the recorded time [s]
  bool plays = true;      // false: an opened scene is paused until a PaceRequest
};

class Session {
 public:
  /// An empty `file` opens no scene: the session waits for an OpenRequest.
  Session(const std::filesystem::path& file, std::vector<std::string> overrides, const SessionParams& params);
  ~Session();  // ends the thread after the current frame or loading step
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void request(Request request);
  /// Newest state. Call it from one thread only. The reference is valid until the next call.
  const SessionStatus& now() { return now_.read(); }
  bool has_news() const { return now_.has_news(); }

 private:
  SessionParams params_;
  latest<SessionStatus> now_;
  RequestQueue queue_;
  std::thread thread_;
};

}  // namespace turgor

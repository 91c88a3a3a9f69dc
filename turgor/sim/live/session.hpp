// A scene that goes on by the clock, on a thread of its own, until told otherwise: to stand still, to go on
// more slowly, to begin again, to be cut, to be another scene. Every body that tools can touch has a tool
// that a mouse may lead (haptics/mouse_device.hpp), felt at 1 kHz. Who looks on reads whole values by
// latest<T>, and may be as slow as they like: nothing here waits for them.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/latest.hpp"
#include "turgor/haptics/mouse_device.hpp"
#include "turgor/sim/deformed_ct.hpp"
#include "turgor/sim/live/live_touch.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// A tool that the mouse may lead.
struct MouseTool {
  int tool = 0;  // of ShownWorld::tools
  std::shared_ptr<haptics::MouseDevice> device;
};

/// Of a tool, once a frame.
struct HapticSample {
  double time = 0, force = 0, depth = 0;  // [s] [N] [m]
  double work = 0;                        // that the hand gave the body and did not get back [J]
};

/// What a session says of itself.
struct SessionNow {
  enum class Phase : std::uint8_t { kLoading, kReady, kFailed };
  Phase phase = Phase::kLoading;
  int world = 0;                       // another number, another world: places of before mean nothing
  std::string doing;                   // while loading
  double done = 0;                     // of that, 0 … 1
  std::string error;                   // why there is no world, or why it stands still
  std::shared_ptr<const Scene> scene;  // as it was loaded; null: it could not be read
  WorldSnapshot snapshot;
  std::vector<MouseTool> mouse;
  std::vector<lattice::Incision> cuts;  // that were asked for and made; `name` is that of their body
  std::vector<std::vector<HapticSample>> haptic;  // of every tool, the newest last, at most kMostFelt
  double pace = 1;                                // that is wished: seconds a second of the clock
  bool plays = true;
  double frame_seconds = 0, show_seconds = 0;  // wall times of a frame, means over some
  double real_pace = 0;                        // that is reached
  bool is_haptic = false;                      // a haptic loop goes on:
  haptics::TimingReport haptics;
  FrameTiming frames;
  std::shared_ptr<const DeformedCt> ct;  // of the first lattice, when asked for last; null: it was not
  std::vector<std::string> notes;        // what a person should know of how the world was made
  std::string saved;                     // what became of the latest AskSave: a sentence

  static constexpr std::size_t kMaxHapticSamples = 900;
  static constexpr int kMostSamples = 160;  // of `ct` here, along an axis
};

/// What a session may be asked for.
struct PaceRequest {
  bool plays = true;
  double pace = 1;  // above 0
};
struct StepRequest {};    // one frame, while it stands still
struct ResetRequest {};   // the same scene from its beginning
struct ReloadRequest {};  // its file as it is now, with what was changed
struct OpenRequest {      // a file, as it is now
  std::filesystem::path file;
  std::vector<std::string> overrides;
};
struct CtRequest {  // see SessionNow::ct
  CtWish wish;
};
/// Writes all that was felt and asked for since the world was loaded: see haptic_recording.hpp and
/// SessionNow::saved.
struct SaveRequest {
  std::filesystem::path file;
};
using Request = std::variant<PaceRequest, StepRequest, ResetRequest, ReloadRequest, OpenRequest, CutRequest,
                             WindRequest, CtRequest, ChangeRequest, SaveRequest>;

struct SessionParams {
  int threads = 0;  // of physics; 0 = one a core
  haptics::LoopParams loop;
  double longest = 120;  // so much of what tools feel is kept [s]
};

class Session {
 public:
  Session(const std::filesystem::path& file, std::vector<std::string> overrides, const SessionParams& params);
  ~Session();  // ends the thread: after the frame, or the loading, that it is at
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void request(Request request);
  /// The newest; by one reader's thread. The reference holds until the next time.
  const SessionNow& now() { return now_.read(); }
  bool has_news() const { return now_.has_news(); }

 private:
  struct Thread;
  SessionParams params_;
  latest<SessionNow> now_;
  std::mutex mutex_;  // of the two below
  std::vector<Request> requests_;
  bool ends_ = false;
  std::condition_variable woken_;
  std::thread thread_;
};

}  // namespace turgor

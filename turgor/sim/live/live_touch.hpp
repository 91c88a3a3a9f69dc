// Haptic interaction with a running world. A haptic thread ticks all tools, those held by devices and those
// on paths. Frames run concurrently by the clock, and neither thread waits for the other. The world must not
// move in memory between start and stop. step() computes its frames. Until stop returns them, the haptic
// thread owns the logs of the tools.
//
//   start   starts the ticks: bodies get `haptic` (exchanges.hpp)
//   step    one frame, each followed by record_frame_inputs and wait_for_frame
//   stop    ends the ticks and returns the tools with their logs to the world
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/haptics/loop.hpp"
#include "turgor/sim/live/frame_clock.hpp"
#include "turgor/sim/live/haptic_log.hpp"
#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/tools/touch_log.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// A tool held by a device. The jaws follow the device's gripper; without one, they close while its button is
/// held.
struct HeldTool {
  int tool = 0;        // index into World::tools
  haptics::Hand hand;  // device, which must be open, and its parameters
  const std::atomic<bool>* is_driven =
      nullptr;  // while it is false the tool follows its path; null: the device always drives the tool
  bool keeps_force = false;  // of a device that no hand holds: a paused world returns the latest force
};

/// Status of a tool: the newest reading and the work done.
struct HapticStatus {
  contact::ToolReading reading;
  double work = 0;                     // net work of the hand on the body [J]
  contact::NeedleReading needle = {};  // of a needle
};

struct LiveParams {
  haptics::LoopParams loop;
  double longest = 600;                    // limit of the recorded time; later ticks are not recorded [s]
  std::size_t in_memory = kTicksInMemory;  // recorded ticks of a tool in memory; the others are on disk
};

class LiveTouch {
 public:
  /// Error: as haptics::Loop::start, a tool index out of range, or two devices that hold the same tool.
  static Result<std::unique_ptr<LiveTouch>> start(World& world, const std::vector<HeldTool>& held,
                                                  const LiveParams& params);
  ~LiveTouch();  // stops
  LiveTouch(const LiveTouch&) = delete;
  LiveTouch& operator=(const LiveTouch&) = delete;

  /// Begins a log beside these results, before the first frame.
  void begin_log(const std::filesystem::path& goal, const Scene& scene);
  /// After every frame: records the inputs that the frame used, and moves recorded ticks to disk.
  void record_frame_inputs();
  /// After a frame: waits until its due time. Returns the delay [s]; it is about 0 for a frame in time.
  double wait_for_frame();
  /// Sets the simulated seconds per second. At 0 the world is paused, and haptic forces are zero except
  /// those of HeldTool::keeps_force.
  void set_pace(double pace);
  /// While the world is paused: permits ticks for this much simulated time [s].
  void allow(double time);
  void stop();

  /// Recording without its scene and requests. Pauses the ticks briefly. Error: the run is longer than the
  /// record, or haptics did not start at frame 0.
  Result<HapticRecording> haptic_recording();

  /// Status of every tool in the newest tick, indexed as World::tools; for one reader thread.
  const std::vector<HapticStatus>& haptic();

  /// Log of begin_log; null without one.
  HapticLogWriter* log();

  const haptics::TimingReport& timing();
  FrameTiming frames() const;
  /// haptics::Loop::news
  std::vector<std::string> news();
  std::vector<std::string> notes() const;

 private:
  struct Impl;
  explicit LiveTouch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace turgor

// A world that is felt while it moves. A haptic thread ticks its tools, those in hands and those on paths;
// frames go on beside it, by the clock, and neither waits for the other. Between start and stop the world
// stays where it is in memory, its frames are made by step() as ever, and what the tools felt is the haptic
// thread's; stop gives it back.
//
//   start   begins to tick; bodies have `felt` (exchanges.hpp)
//   step    frames, each when wait_for_frame says so
//   stop    ends the ticks; the tools, with what they felt, are the world's again
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/haptics/loop.hpp"
#include "turgor/sim/live/frame_clock.hpp"
#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// A tool of the world in a hand. Jaws follow the device's gripper, or close while its button is held.
struct HeldTool {
  int tool = 0;                               // index into World::tools
  haptics::Hand hand;                         // its device is open
  const std::atomic<bool>* is_led = nullptr;  // while it is false the tool goes on its path; null: always led
};

/// Of a tool: the newest tick, and what its hand has given the body since the beginning and not got back.
struct HapticStatus {
  contact::ToolReading reading;
  double work = 0;  // [J]
};

struct LiveParams {
  haptics::LoopParams loop;
  double longest = 600;  // so much of what tools feel is kept, what comes later is only felt [s]
};

class LiveTouch {
 public:
  /// Error: see haptics::Loop::start; a tool that is not in the world.
  static Result<std::unique_ptr<LiveTouch>> start(World& world, const std::vector<HeldTool>& held,
                                                  const LiveParams& params);
  ~LiveTouch();  // stops
  LiveTouch(const LiveTouch&) = delete;
  LiveTouch& operator=(const LiveTouch&) = delete;

  /// After every frame: what it knew of the ticks.
  void note_frame();
  /// After a frame: until the world's next one is due; at once when it is late. Answers how late [s].
  double wait_for_frame();
  /// Seconds of the world a second of the clock, from now on; at 0 nothing moves and nothing is felt.
  void set_pace(double pace);
  /// While nothing moves: this much of the world's time is ticked yet [s].
  void allow(double time);
  void stop();

  /// All that decided what became of the world since it was loaded, but the scene and what was asked for; the
  /// ticks rest for a moment. Error: it was longer than what is kept, or began elsewhere than at frame 0.
  Result<HapticRecording> haptic_recording();

  /// What every tool felt in the newest tick, as World::tools; by one reader's thread.
  const std::vector<HapticStatus>& haptic();

  const haptics::TimingReport& timing();
  FrameTiming frames() const;
  std::vector<std::string> notes() const;

 private:
  struct Parts;
  explicit LiveTouch(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace turgor

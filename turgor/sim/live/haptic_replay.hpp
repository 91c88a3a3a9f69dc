// Replay of a haptic recording without devices and without a clock. Every tick uses its recorded command and
// frame data. Every frame starts after the ticks that it used in the recording. One thread runs both.
//
//   begin        replaces LiveTouch::start
//   next_frame   before every frame: applies requests, and runs the ticks that the frame used
//   end          runs the ticks after the last frame, and returns the tools to the world
#pragma once

#include <memory>

#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

class HapticReplay {
 public:
  /// Starts the replay in a new world of the recorded scene. Error: the world has other tools, tools of a
  /// body have different numbers of ticks, or the recorded scene is invalid.
  static Result<std::unique_ptr<HapticReplay>> begin(World& world, HapticRecording run);
  ~HapticReplay();
  HapticReplay(const HapticReplay&) = delete;
  HapticReplay& operator=(const HapticReplay&) = delete;

  /// Error: a recorded request cannot be applied.
  Status next_frame(const Exec& exec);
  void end();
  const HapticRecording& run() const;

 private:
  struct Impl;
  explicit HapticReplay(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace turgor

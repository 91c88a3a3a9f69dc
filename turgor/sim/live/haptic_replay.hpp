// A felt run again, without devices and without a clock: every tick gets what its hand said, and answers from
// what it answered from; every frame knows the ticks that it knew. One thread does both in turn.
//
//   begin        in place of LiveTouch::start
//   next_frame   before every frame: what was asked for, and the ticks that the frame knew
//   end          what was ticked after the last frame; the tools are the world's again
#pragma once

#include <memory>

#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

class HapticReplay {
 public:
  /// A world that was just made of the run's scene. Error: it has other tools.
  static Result<std::unique_ptr<HapticReplay>> begin(World& world, HapticRecording run);
  ~HapticReplay();
  HapticReplay(const HapticReplay&) = delete;
  HapticReplay& operator=(const HapticReplay&) = delete;

  /// Error: something asked for is refused that was granted then.
  Status next_frame(const Exec& exec);
  void end();
  const HapticRecording& run() const;

 private:
  struct Parts;
  explicit HapticReplay(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace turgor

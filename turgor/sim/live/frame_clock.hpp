// Due times of frames: the wall-clock time at which each frame must be finished.
#pragma once

#include <optional>

namespace turgor {

/// Delays of frames.
struct FrameTiming {
  long frames = 0, late = 0;  // late: delayed by more than a frame's duration
  double latest = 0;          // largest delay [s]
};

class FrameClock {
 public:
  explicit FrameClock(double dt) : dt_(dt) {}

  /// Sets the simulated seconds per wall-clock second, above 0. The next frame counts as in time.
  void set_pace(double pace) { pace_ = pace, start_.reset(); }
  /// After a frame: waits until its due time. Returns the delay [s]; it is about 0 for a frame in time.
  double wait(int frame);
  const FrameTiming& timing() const { return timing_; }

 private:
  double dt_, pace_ = 1;         // frame length [s]; pace [1]
  std::optional<double> start_;  // wall-clock time of frame 0 [s]; empty: set by the next wait
  FrameTiming timing_;
};

}  // namespace turgor

// When frames are due: a world's time against the machine's.
#pragma once

#include <optional>

namespace turgor {

/// How frames kept up.
struct FrameTiming {
  long frames = 0, late = 0;  // late: begun more than a frame's time after they were due
  double latest = 0;          // [s]
};

class FrameClock {
 public:
  explicit FrameClock(double dt) : dt_(dt) {}

  /// Seconds of the world a second of the machine, above 0. What was late is forgotten.
  void set_pace(double pace) { pace_ = pace, began_.reset(); }
  /// After a frame: until the next one is due; at once when it is late. Answers how late [s].
  double wait(int frame);
  const FrameTiming& timing() const { return timing_; }

 private:
  double dt_, pace_ = 1;         // [s] [1]
  std::optional<double> began_;  // when frame 0 would have been due [s]
  FrameTiming timing_;
};

}  // namespace turgor

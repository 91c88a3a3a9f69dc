// A thread that only wakes up periodically. It measures the jitter and the misses of the machine itself, as a
// baseline for a haptic loop at the same time.
#pragma once

#include <atomic>
#include <thread>

#include "turgor/haptics/timing_report.hpp"

namespace turgor {

class EmptyLoop {
 public:
  /// Starts the thread with the priority that haptics::Loop would request.
  EmptyLoop(double rate, int priority);
  ~EmptyLoop() { end(); }
  EmptyLoop(const EmptyLoop&) = delete;
  EmptyLoop& operator=(const EmptyLoop&) = delete;

  /// Stops the thread and returns its periods, jitter and missed ticks.
  haptics::TimingReport end();

 private:
  void run();

  double rate_;
  int priority_;
  std::atomic<bool> ends_ = false;
  haptics::TimingRecord record_;
  std::thread thread_;
};

}  // namespace turgor

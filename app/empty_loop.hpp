// A thread that does nothing but wake up in time: what a machine misses by itself, to lie beside what a
// haptic loop misses on it.
#pragma once

#include <atomic>
#include <thread>

#include "turgor/haptics/timing_report.hpp"

namespace turgor {

class EmptyLoop {
 public:
  /// Begins; asks for a priority as haptics::Loop does.
  EmptyLoop(double rate, int priority);
  ~EmptyLoop() { end(); }
  EmptyLoop(const EmptyLoop&) = delete;
  EmptyLoop& operator=(const EmptyLoop&) = delete;

  /// Ends: periods, how far they were from what was asked for, and what was missed.
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

// Progress bar on standard error with the finished fraction and the time remaining. It is silent unless
// standard error is a terminal. A bar that was never updated prints nothing.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "turgor/core/timing.hpp"

namespace turgor {

/// Called with the finished fraction in [0, 1]; may be called from any thread.
using Progress = std::function<void(double)>;

class ProgressBar {
 public:
  explicit ProgressBar(const std::string& label);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void update(double fraction);
  Progress callback() {
    return [this](double fraction) { update(fraction); };
  }

 private:
  std::string label_;
  bool shown_;
  Timer timer_;
  std::atomic<int> last_tenth_{-1};  // time of the last drawing, in tenths of a second
};

}  // namespace turgor

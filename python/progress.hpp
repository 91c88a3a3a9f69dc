// Progress callbacks in Python. Exceptions of the callback are stored and rethrown by the calling thread,
// since progress may come from any thread.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>

#include "arrays.hpp"
#include "turgor/sim/loading.hpp"

namespace turgor {

class PyProgress {
 public:
  /// `callback`: called with a label and the finished fraction, or None.
  explicit PyProgress(nb::object callback) : callback_(std::move(callback)) {}

  /// Requires that the interpreter lock is released.
  BeginWork begin() {
    if (callback_.is_none()) return {};
    return [this](const std::string& label, const std::string&) -> Progress {
      auto percent = std::make_shared<std::atomic<int>>(-1);
      return [this, label, percent](double fraction) {
        if (const int now = int(100 * fraction); percent->exchange(now) != now) report(label, fraction);
      };
    };
  }
  bool failed() const { return failed_; }
  /// Rethrows the first exception of the callback.
  void rethrow() {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void report(const std::string& label, double fraction) {
    if (failed_) return;
    const nb::gil_scoped_acquire python;
    try {
      callback_(label, fraction);
    } catch (...) {
      if (!failed_.exchange(true)) failure_ = std::current_exception();
    }
  }

  nb::object callback_;
  std::atomic<bool> failed_{false};
  std::exception_ptr failure_;
};

}  // namespace turgor

// Python functions that are told how far something is. An exception of theirs waits until it can be thrown:
// work may be told about from any thread.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>

#include "arrays.hpp"
#include "turgor/sim/loading.hpp"

namespace turgor {

class PyProgress {
 public:
  /// `told`: called with a word and the finished fraction, or None.
  explicit PyProgress(nb::object told) : told_(std::move(told)) {}

  /// To be called without the interpreter's lock.
  BeginWork begin() {
    if (told_.is_none()) return {};
    return [this](const std::string& label, const std::string&) -> Progress {
      auto percent = std::make_shared<std::atomic<int>>(-1);
      return [this, label, percent](double fraction) {
        if (const int now = int(100 * fraction); percent->exchange(now) != now) tell(label, fraction);
      };
    };
  }
  bool failed() const { return failed_; }
  /// What the function threw first.
  void rethrow() {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void tell(const std::string& label, double fraction) {
    if (failed_) return;
    const nb::gil_scoped_acquire python;
    try {
      told_(label, fraction);
    } catch (...) {
      if (!failed_.exchange(true)) failure_ = std::current_exception();
    }
  }

  nb::object told_;
  std::atomic<bool> failed_{false};
  std::exception_ptr failure_;
};

}  // namespace turgor

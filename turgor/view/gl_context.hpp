// One OpenGL context per process, through EGL without a surface. It is created on first use; one thread holds
// it at a time, others wait. Without EGL or a driver the result is an error.
#pragma once

#include <mutex>

#include "turgor/core/result.hpp"

namespace turgor {

/// During its lifetime the context is current on the thread that created it, and on no other.
class CurrentGl {
 public:
  CurrentGl(CurrentGl&&) = default;
  ~CurrentGl();

 private:
  friend Result<CurrentGl> hold_gl();
  explicit CurrentGl(std::unique_lock<std::mutex> lock) : lock_(std::move(lock)) {}
  std::unique_lock<std::mutex> lock_;
};

/// OpenGL 3.3 core or newer. Error: the missing library, or the failed call with its code.
Result<CurrentGl> hold_gl();

}  // namespace turgor

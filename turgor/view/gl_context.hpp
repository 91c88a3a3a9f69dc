// One OpenGL context a process, through EGL without any surface. It is created when first used; whoever draws
// holds it, and others wait. A machine without EGL or without a driver gets an error, not a crash.
#pragma once

#include <mutex>

#include "turgor/core/result.hpp"

namespace turgor {

/// While this lives, the context is current on the thread that made it, and on no other.
class CurrentGl {
 public:
  CurrentGl(CurrentGl&&) = default;
  ~CurrentGl();

 private:
  friend Result<CurrentGl> hold_gl();
  explicit CurrentGl(std::unique_lock<std::mutex> lock) : lock_(std::move(lock)) {}
  std::unique_lock<std::mutex> lock_;
};

/// OpenGL 3.3 core or newer. Error: what is missing, or which call failed and with which code.
Result<CurrentGl> hold_gl();

}  // namespace turgor

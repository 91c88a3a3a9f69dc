#include "turgor/sim/bodies/sfem/patch_worker.hpp"

#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/start_thread.hpp"

namespace turgor {

PatchWorker::PatchWorker(const PatchWorker& other) {
  other.settle();
  built_ = other.built_, is_busy_ = other.is_busy_;
}

PatchWorker::~PatchWorker() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PatchWorker::begin(Build build) {
  TURGOR_ASSERT(!is_busy_, "a worker builds one patch at a time");
  TURGOR_ASSERT(build != nullptr, "a worker has work");
  is_busy_ = true;
  // start the thread; without one the caller builds
  if (!thread_.joinable()) {
    Result<std::thread> started = start_thread("the patch worker", [this] { work(); });
    if (!started) {
      BuiltPatch built = build();
      const std::lock_guard lock(mutex_);
      built_ = std::move(built);
      return;
    }
    thread_ = std::move(*started);
  }
  // hand over the work
  {
    const std::lock_guard lock(mutex_);
    build_ = std::move(build);
  }
  changed_.notify_all();
}

bool PatchWorker::is_ready() {
  const std::lock_guard lock(mutex_);
  return built_.has_value();
}

void PatchWorker::settle() const {
  if (!is_busy_) return;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return built_.has_value(); });
}

BuiltPatch PatchWorker::finish() {
  TURGOR_ASSERT(is_busy_, "a patch is finished after it was begun");
  settle();
  const std::lock_guard lock(mutex_);
  TURGOR_CHECK(built_.has_value(), "a settled worker has built its patch");
  BuiltPatch built = std::move(*built_);
  built_.reset();
  is_busy_ = false;
  return built;
}

void PatchWorker::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ends_ || build_; });
    if (!build_) return;
    const Build build = std::exchange(build_, nullptr);
    lock.unlock();
    BuiltPatch built = build();
    lock.lock();
    built_ = std::move(built);
    changed_.notify_all();
  }
}

}  // namespace turgor

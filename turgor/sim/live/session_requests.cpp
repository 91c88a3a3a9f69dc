#include "turgor/sim/live/session_requests.hpp"

#include <utility>

#include "turgor/core/assert.hpp"

namespace turgor {

void RequestQueue::push(Request request) {
  {
    const std::lock_guard lock(mutex_);
    requests_.push_back(std::move(request));
  }
  wake_.notify_one();
}

void RequestQueue::end() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  wake_.notify_one();
}

bool RequestQueue::take(bool waits, std::deque<Request>& taken) {
  TURGOR_CHECK(taken.empty(), "a batch of requests is handled before the next one is taken");
  std::unique_lock lock(mutex_);
  if (waits) wake_.wait(lock, [this] { return is_ending_ || !requests_.empty(); });
  taken.swap(requests_);
  return !is_ending_;
}

void RequestQueue::wait_until(std::chrono::steady_clock::time_point time) {
  std::unique_lock lock(mutex_);
  wake_.wait_until(lock, time, [this] { return is_ending_; });
}

}  // namespace turgor

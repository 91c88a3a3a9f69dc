#include "turgor/core/start_thread.hpp"

#include <algorithm>
#include <mutex>
#include <vector>

#include <pthread.h>

namespace turgor {

void name_thread(std::thread& thread, const std::string& purpose) {
  constexpr std::size_t kLongest = 15;  // of a thread's name on Linux
  const std::string name = purpose.substr(purpose.starts_with("the ") ? 4 : 0);
  pthread_setname_np(thread.native_handle(), name.substr(0, kLongest).c_str());
}

int startable_threads(int wanted) {
  static std::mutex mutex;
  static int known = 1;  // largest number that was started at once
  const std::lock_guard lock(mutex);
  if (wanted <= known) return wanted;

  // all of them wait until the last one has started
  std::vector<std::thread> started;
  started.reserve(std::size_t(wanted) - 1);
  std::mutex gate;
  std::unique_lock closed(gate);
  while (int(started.size()) + 1 < wanted) {
    Result<std::thread> thread = start_thread("a loop", [&gate] { const std::lock_guard wait(gate); });
    if (!thread) break;
    started.push_back(std::move(*thread));
  }
  closed.unlock();
  for (std::thread& thread : started) thread.join();
  known = std::max(known, int(started.size()) + 1);
  return std::min(wanted, known);
}

}  // namespace turgor

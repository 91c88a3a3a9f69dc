#include "turgor/haptics/real_time.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

namespace turgor::haptics {

double steady_seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

void sleep_until(double seconds) {
  const double whole = std::floor(seconds);
  const timespec then{.tv_sec = time_t(whole), .tv_nsec = long((seconds - whole) * 1e9)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &then, nullptr) == EINTR) {
  }
}

std::string set_real_time_priority(int priority) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // 1 ns instead of the default of 50 µs
  const int lowest = sched_get_priority_min(SCHED_FIFO), highest = sched_get_priority_max(SCHED_FIFO);
  const sched_param param{.sched_priority = std::clamp(priority, lowest, highest)};
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  if (refused == 0) return {};
  return fmt::format(
      "the haptic thread has no real-time priority ({}): ticks may come late; allow it with `ulimit -r {}` "
      "or "
      "in /etc/security/limits.conf",
      std::strerror(refused), param.sched_priority);
}

void prefault_stack() {
  volatile char stack[1 << 17];
  for (std::size_t i = 0; i < sizeof stack; i += 1024) stack[i] = 0;
}

std::string lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_ONFAULT) == 0) return {};
  return fmt::format(
      "memory is not locked ({}): a tick may wait for the disk; allow it with `ulimit -l unlimited`",
      std::strerror(errno));
}

void unlock_memory() { munlockall(); }

}  // namespace turgor::haptics

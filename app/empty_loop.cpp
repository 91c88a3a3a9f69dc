#include "app/empty_loop.hpp"

#include <cmath>

#include "app/commands.hpp"
#include "turgor/core/start_thread.hpp"
#include "turgor/haptics/real_time.hpp"

namespace turgor {

EmptyLoop::EmptyLoop(double rate, int priority)
    : rate_(rate),
      priority_(priority),
      thread_(required(start_thread("the empty loop", [this] { run(); }))) {}

void EmptyLoop::run() {
  if (priority_ > 0) (void)haptics::set_real_time_priority(priority_);
  const double period = 1 / rate_;
  double next = haptics::steady_seconds(), before = next;
  while (!ends_) {
    next += period;
    if (const double late = haptics::steady_seconds() - next;
        late > period) {  // as haptics::Loop counts them
      record_.missed += std::uint64_t(std::floor(late / period));
      next += std::floor(late / period) * period;
    }
    haptics::sleep_until(next);
    const double now = haptics::steady_seconds();
    record_.period.add(now - before);
    record_.jitter.add(std::abs(now - before - period));
    record_.compute.add(0);  // timing_report counts ticks by it
    before = now;
  }
}

haptics::TimingReport EmptyLoop::end() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
  haptics::TimingReport report = haptics::timing_report(record_);
  report.target_rate = rate_;
  return report;
}

}  // namespace turgor

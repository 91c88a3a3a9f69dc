#include "turgor/sim/live/frame_clock.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/haptics/real_time.hpp"

namespace turgor {

double FrameClock::wait(int frame) {
  TURGOR_CHECK(pace_ > 0 && dt_ > 0, "a clock runs forwards");
  const double passed = frame * dt_ / pace_;
  if (!start_) start_ = haptics::steady_seconds() - passed;  // the first frame is in time by definition
  const double due = *start_ + passed;
  haptics::sleep_until(due);
  const double late = haptics::steady_seconds() - due;
  timing_.frames++;
  timing_.late += late > dt_ / pace_;
  timing_.latest = std::max(timing_.latest, late);
  return late;
}

}  // namespace turgor

#include "turgor/sim/live/frame_clock.hpp"

#include <algorithm>

#include "turgor/haptics/real_time.hpp"

namespace turgor {

double FrameClock::wait(int frame) {
  const double passed = frame * dt_ / pace_;
  if (!began_) began_ = haptics::steady_seconds() - passed;  // the first one is in time
  const double due = *began_ + passed;
  haptics::sleep_until(due);
  const double late = haptics::steady_seconds() - due;
  timing_.frames++;
  timing_.late += late > dt_ / pace_;
  timing_.latest = std::max(timing_.latest, late);
  return late;
}

}  // namespace turgor

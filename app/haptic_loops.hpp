// Haptic loops that are timed, each beside an empty one: for some seconds with nothing, a wall or a chain of
// rhombi behind the hand, and for minutes with a whole world.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/haptics/timing_report.hpp"

namespace turgor {

/// What answers the hand.
enum class LoopModel : std::uint8_t { kNone, kWall, kRhombus };

struct HapticLoopRow {
  LoopModel model = LoopModel::kNone;
  haptics::TimingReport report, empty;  // of the loop, and of an empty one at the same time
  std::vector<std::string> notes;       // what the system did not allow
};
const char* name_of(LoopModel model);

/// A computed arm in a light hand that taps once a second, for some seconds.
HapticLoopRow measure_loop(double rate, LoopModel model, double seconds);

/// A liver of rhombus chains that a hand taps for minutes, with frames beside the ticks.
struct HapticSoak {
  haptics::TimingReport report, empty;
  double drift = 0;                          // of ticks against the clock, in the end [s]
  double resident_before = 0, resident = 0;  // memory, when it had settled and in the end [bytes]
  long frames = 0, frames_late = 0;
  double largest_force = 0;  // that the hand was given at the body [N]
  std::vector<std::string> notes;
};
Result<HapticSoak> soak_haptics(double minutes, const Progress& progress);

void print(const HapticSoak& soak);
std::string to_json_text(const HapticSoak& soak);

}  // namespace turgor

// Timing of haptic loops, each beside an empty loop. Short runs have no contact, a wall, or a rhombus chain
// behind the hand; the soak test runs a whole world for minutes.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/haptics/timing_report.hpp"

namespace turgor {

/// Source of the contact force.
enum class LoopModel : std::uint8_t { kNone, kWall, kRhombus };

struct HapticLoopRow {
  LoopModel model = LoopModel::kNone;
  haptics::TimingReport report, empty;  // of the loop, and of an empty one at the same time
  std::vector<std::string> notes;       // settings that the operating system refused
};
const char* name_of(LoopModel model);

/// Times a loop in which a simulated arm in a light hand taps once a second.
HapticLoopRow measure_loop(double rate, LoopModel model, double seconds);

/// Soak test: a hand taps a liver of rhombus chains for minutes, with frames in parallel.
struct HapticSoak {
  haptics::TimingReport report, empty;
  double drift = 0;                          // of the tick count against the clock, at the end [s]
  double resident_before = 0, resident = 0;  // resident memory after the start and at the end [bytes]
  long frames = 0, frames_late = 0;
  double largest_force = 0;  // largest force on the hand at the body [N]
  std::vector<std::string> notes;
};
Result<HapticSoak> soak_haptics(double minutes, const Progress& progress);

void print(const HapticSoak& soak);
std::string to_json_text(const HapticSoak& soak);

}  // namespace turgor

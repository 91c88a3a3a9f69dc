// Haptic benchmarks: timing of the haptic loop, cost of a tick, and the Z-width of a simulated hand on
// virtual walls. The Z-width is measured over physics rates, with and without the passivity controller
// (Colgate and Brown).
#pragma once

#include <string>
#include <vector>

#include "app/haptic_loops.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/haptics/z_width.hpp"

namespace turgor {

/// Verdicts over a grid of walls: stable if the hand stops.
struct ZWidthMap {
  std::string name;
  haptics::WallAnswer answer = haptics::WallAnswer::kTick;
  double frame_rate = 0;  // rate of physics [Hz]
  bool controller = false;
  std::vector<haptics::WallVerdict> verdicts;  // one row of stiffnesses for each damping
};

struct HapticsBench {
  std::vector<HapticLoopRow> loops;
  haptics::WallTrial trial;                // arm and hand of all maps
  std::vector<double> stiffness, damping;  // of the walls [N/m] [N·s/m]
  std::vector<ZWidthMap> maps;
};

/// Runs each loop for `seconds`; 0 skips the loops.
HapticsBench bench_haptics(const Exec& exec, double seconds, const Progress& progress);

void print(const HapticsBench& bench);
std::string to_json_text(const HapticsBench& bench);
/// SVG of the maps, with Colgate's bound in each.
std::string z_width_svg(const HapticsBench& bench);

}  // namespace turgor

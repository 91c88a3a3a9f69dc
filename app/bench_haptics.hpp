// What touching costs on this machine: how well a haptic loop keeps its time and what it takes of a tick, and
// how stiff a wall a computed hand can press before it shakes, over the rates of physics, with and without
// the passivity controller (Colgate and Brown's Z-width).
#pragma once

#include <string>
#include <vector>

#include "app/haptic_loops.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/haptics/z_width.hpp"

namespace turgor {

/// Which walls of a grid come to rest.
struct ZWidthMap {
  std::string name;
  haptics::WallAnswer answer = haptics::WallAnswer::kTick;
  double frame_rate = 0;  // of physics [Hz]
  bool controller = false;
  std::vector<haptics::WallVerdict> verdicts;  // a row of stiffnesses for each damping
};

struct HapticsBench {
  std::vector<HapticLoopRow> loops;
  haptics::WallTrial trial;                // arm and hand of all maps
  std::vector<double> stiffness, damping;  // of the walls [N/m] [N·s/m]
  std::vector<ZWidthMap> maps;
};

/// Loops run `seconds` each; 0 leaves them out.
HapticsBench bench_haptics(const Exec& exec, double seconds, const Progress& progress);

void print(const HapticsBench& bench);
std::string to_json_text(const HapticsBench& bench);
/// The maps with Colgate's bound in each.
std::string z_width_svg(const HapticsBench& bench);

}  // namespace turgor

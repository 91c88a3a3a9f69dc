// What touching a body of the rhombus model costs on this machine: the force of a haptic tick, the picture
// of the body that moves, over sizes; the paper's figures beside.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/progress.hpp"

namespace turgor {

/// A ball that slides 8 to 10 mm below the surface of the phantom liver, on one thread. Medians.
struct RhombusRow {
  int vertices = 0, triangles = 0;
  int moved = 0;                   // vertices within reach of the touch
  double force = 0, force_99 = 0;  // a haptic tick [s]
  double picture = 0;              // all vertices, the touch where it was before [s]
  double bulging = 0;              // the same with the volume kept [s]
  double sliding = 0;              // with distances along the surface measured again [s]
  double jump = 0;                 // largest of the force per 10 µm of the way [N]
  double strongest = 0;            // [N]
};

std::vector<RhombusRow> bench_rhombus(const Progress& progress);

void print(const std::vector<RhombusRow>& rows);
std::string to_json_text(const std::vector<RhombusRow>& rows);

}  // namespace turgor

// Cost of a touch on a body of the rhombus model on this machine: force of a haptic tick and deformed surface
// over sizes, beside the figures of the paper.
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
  double picture = 0;              // all vertices, touch unmoved [s]
  double bulging = 0;              // the same with volume preservation [s]
  double sliding = 0;              // with surface distances recomputed [s]
  double jump = 0;                 // largest change of the force per 10 µm of tool displacement [N]
  double strongest = 0;            // largest force [N]
};

std::vector<RhombusRow> bench_rhombus(const Progress& progress);

void print(const std::vector<RhombusRow>& rows);
std::string to_json_text(const std::vector<RhombusRow>& rows);

}  // namespace turgor

// Cost of frames after a cut over the size of the body. It shows whether the cost grows with the moving
// region or with the whole body.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"

namespace turgor {

struct GrowthRow {
  int nodes = 0;
  double awake_ms = 0;  // median time of a frame when every row is swept
  double ms = 0;        // median time of a frame when rows may sleep
  double asleep = 0;    // mean fraction of rows asleep [1]
};

/// Measures the second after the same cut in bodies of growing size.
std::vector<GrowthRow> bench_growth(const Exec& exec);

}  // namespace turgor

// What a cut in a body costs: what it moves, or what the body has.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"

namespace turgor {

struct GrowthRow {
  int nodes = 0;
  double awake_ms = 0;  // a frame, median, when every row is swept
  double ms = 0;        // when rows may sleep
  double asleep = 0;    // of the rows, mean
};

/// The second after the same cut in bodies of more and more nodes.
std::vector<GrowthRow> bench_growth(const Exec& exec);

}  // namespace turgor

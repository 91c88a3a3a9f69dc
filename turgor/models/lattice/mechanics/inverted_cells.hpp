// Cells that are turned inside out: nothing that is drawn or measured there means anything.
#pragma once

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct InvertedCells {
  int count = 0;
  Int3 first;  // the lowest node of one of them
};

/// Cells of body, without a cut edge, whose volume at the middle is negative.
InvertedCells find_folded_cells(const Exec& exec, const Model& model, const State& state);

/// How far tissue goes on below the bottom of a cut, in lattice steps and up to `most`: the least along the
/// line from `from` to `to`, which lies at the bottom of the cut, towards `into` (lattice frame, unit). The
/// body is that of the CT.
double cells_below(const Model& model, Vec3d from, Vec3d to, Vec3d into, double most);

}  // namespace turgor::lattice

// Inverted cells. Pictures and measures are meaningless in them.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

struct InvertedCells {
  int count = 0;
  Int3 first;  // lowest node of one of them
};

/// Counts uncut body cells whose volume at the center is negative.
InvertedCells find_inverted_cells(const Exec& exec, const Model& model, const State& state);

/// Depth of tissue below the bottom of a cut, in cells, at most `most`: the minimum along the line
/// `from`–`to` at the bottom of the cut, in the direction `into` (lattice frame, unit). It uses the body in
/// the CT.
double cells_below(const Model& model, Vec3d from, Vec3d to, Vec3d into, double most);

}  // namespace turgor::lattice

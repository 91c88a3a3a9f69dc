// How much of a cell a blade went through: of lines through the cell, a regular grid of them along each axis,
// those that it crossed. Finer than the fine lattice, so that a wound grows as its blade does.
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor::lattice {

constexpr int kLineGrid = 8, kLines = kLineGrid * kLineGrid;

/// Where a line along an axis enters its cell, in coordinates of the cell from 0 to 1.
constexpr Vec3d line_start(int axis, int line) {
  Vec3d at;
  const int column = line % kLineGrid, row = line / kLineGrid;
  at[(axis + 1) % 3] = (column + 0.5) / kLineGrid;
  at[(axis + 2) % 3] = (row + 0.5) / kLineGrid;
  return at;
}

/// Adds the lines that a blade crosses between two places of its path [m], and wakes what sleeps there.
void mark_cut_samples(const Model& model, State& state, const BladePath& path, double begin, double end,
                      int incision);

/// What share of the plane between the two pieces of a tip its blade went through, in [0, 1].
double cut_fraction(const State& state, const Fragments& pieces, const CutCell& cell, const CrackTip& tip);

}  // namespace turgor::lattice

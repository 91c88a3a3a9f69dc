// Cut fraction at a crack tip: the fraction of the cell's section that the blade has cut, estimated by
// sampling. A regular grid of lines runs through the cell along each axis. The lines that a blade crossed are
// counted. The samples are finer than the fine lattice, so a wound grows continuously with its blade.
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor::lattice {

constexpr int kLineGrid = 8, kLines = kLineGrid * kLineGrid;

/// Start of a sample line on the lower face of its cell, in cell coordinates from 0 to 1.
constexpr Vec3d line_start(int axis, int line) {
  Vec3d at;
  const int column = line % kLineGrid, row = line / kLineGrid;
  at[(axis + 1) % 3] = (column + 0.5) / kLineGrid;
  at[(axis + 2) % 3] = (row + 0.5) / kLineGrid;
  return at;
}

/// Marks the sample lines that a blade crosses between two arc lengths of its path [m], and wakes sleeping
/// rows around them.
void mark_cut_samples(const Model& model, State& state, const BladePath& path, double begin, double end,
                      int incision);

/// True if the blade of an incision crossed a sample line of a cell.
bool is_sampled(const Cuts& cuts, int slot, std::uint8_t incision);
/// Number of incisions with this property.
int sampled_incisions(const Cuts& cuts, int slot);

/// Fraction of the plane between the two fragments of a crack tip that the blade has cut, in [0, 1].
double cut_fraction(const Cuts& cuts, const Fragments& fragments, const CutCell& cell, const CrackTip& tip);

}  // namespace turgor::lattice

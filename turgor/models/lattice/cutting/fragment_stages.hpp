// Reuse of fragments while a blade moves. A cut changes the fragments of the cells in and around which edges
// are cut. Later fragments copy all other cells from those of earlier cuts, and have the bits of fragments
// that are made from the beginning.
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Cells of fragments that are as in those of earlier cuts.
struct EarlierFragments {
  const Fragments* fragments = nullptr;  // null: none
  std::vector<int> cell;  // by cell: its index then; −1 = an edge in or around it was cut since, or it is new

  /// Index then, or −1.
  int index(int c) const { return fragments ? cell[std::size_t(c)] : -1; }
  int index(const Fragments& out, const CutCell& c) const { return index(int(&c - out.cells.data())); }
};

/// Cut bits at the eight corners of a cell, and between them the number of incisions with crossed sample
/// lines in it (cut_fraction.hpp).
std::uint64_t cuts_at_corners(const Cuts& cuts, const Lattice& lattice, int slot);

/// Finds the cells of `out` that are as in `before`, which is null or belongs to a prefix of the present cut
/// edges. `out` has its cells. Sets the part of FragmentStages that depends on the cuts only.
EarlierFragments find_earlier(const Fragments* before, const Cuts& cuts, Fragments& out);

/// Copies labels of tissue, fragments and crack tips of a cell. The corners are its own nodes.
void copy_cell(const Fragments& before, int index, CutCell& cell, Fragments& out);
/// Copies the labels of a cell with those of air, without ghosts.
void copy_air_labels(const Fragments& before, int index, const CutCell& cell, Fragments& out);

}  // namespace turgor::lattice

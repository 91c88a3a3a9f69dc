// Labels of air in cut cells, after those of their tissue.
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Sub-lattice of one cell: labels, cut bits and neighbors along uncut edges.
struct CellSubLattice {
  const FineLattice& fine;
  const std::uint8_t* cut;
  std::int16_t* label;
  int offset[kFamilyCount];

  CellSubLattice(Fragments& fragments, const CutCell& cell)
      : fine(fragments.fine),
        cut(&fragments.cut_bits[cell.first_sub_index]),
        label(&fragments.label[cell.first_sub_index]) {
    for (int n = 0; n < kFamilyCount; n++) offset[n] = sub_index(fine, kFamilies[std::size_t(n)]);
  }
  /// Calls visit(neighbor, its sub-lattice index) for all neighbors of a node in the cell along uncut edges.
  template <class Visit>
  void for_connected(Int3 local, const Visit& visit) const {
    const int sub_node = sub_index(fine, local);
    for (int n = 0; n < kFamilyCount; n++) {
      const Int3 up = local + kFamilies[std::size_t(n)], down = local - kFamilies[std::size_t(n)];
      if (in_cell(fine, up) && !(cut[sub_node] >> n & 1)) visit(up, sub_node + offset[n]);
      if (in_cell(fine, down) && !(cut[sub_node - offset[n]] >> n & 1)) visit(down, sub_node - offset[n]);
    }
  }
};

/// Labels air like the nearest tissue on its side of the blades. Air without such tissue keeps -1.
void label_air(const CellSubLattice& sub_lattice);
/// Finds the ghosts of a cell. Seeds are unlabeled nodes on its border that have a label in another cell.
/// Their ghosts spread along uncut edges to the other unlabeled nodes.
void find_ghosts(Fragments& out, CutCell& cell);

}  // namespace turgor::lattice

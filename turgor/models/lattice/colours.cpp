#include "turgor/models/lattice/colours.hpp"

namespace turgor::lattice {

ColourBegin groups_by_colours(const Lattice& l, const Runs& runs, std::vector<int>& groups) {
  ColourBegin of;
  for (int colour = 0; colour < kColourCount; colour++) {
    of.begin[colour] = int(groups.size());
    const ColourRows rows(l.size, colour);
    for (std::size_t n = 0; n < rows.count(); n++) {
      const auto [parity, j, k] = rows[n];
      for (const Run run : runs.of_half_row(row_slot(l, j, k) / l.half + parity))
        for (int s = run.begin; s < run.begin + run.count; s += kGroup) groups.push_back(s);
    }
  }
  of.begin[kColourCount] = int(groups.size());
  return of;
}

}  // namespace turgor::lattice

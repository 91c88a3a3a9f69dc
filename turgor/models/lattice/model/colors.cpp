#include "turgor/models/lattice/model/colors.hpp"

namespace turgor::lattice {

ColorBegin groups_by_colors(const Lattice& l, const Runs& runs, std::vector<int>& groups) {
  ColorBegin of;
  for (int color = 0; color < kColorCount; color++) {
    of.begin[color] = int(groups.size());
    const ColorRows rows(l.size, color);
    for (std::size_t n = 0; n < rows.count(); n++) {
      const auto [parity, j, k] = rows[n];
      for (const Run run : runs.of_half_row(row_slot(l, j, k) / l.half + parity))
        for (int s = run.begin; s < run.begin + run.count; s += kGroup) groups.push_back(s);
    }
  }
  of.begin[kColorCount] = int(groups.size());
  return of;
}

}  // namespace turgor::lattice

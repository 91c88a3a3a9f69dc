// Connected components of a mask by union-find on runs of rows. Memory and time scale with the surface of the
// marked region, not with its volume.
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

/// Marked cells (begin … end - 1, j, k).
struct CellRun {
  int begin = 0, end = 0, j = 0, k = 0;
  int component = 0;  // index into RowComponents::sizes
};
struct RowComponents {
  std::vector<CellRun> runs;       // by k, then j, then begin
  std::vector<std::size_t> sizes;  // cells of each component; components in the order of their first runs

  int largest() const;  // -1 if nothing is marked
};

/// Cells are 0 or 1, i fastest, and connected by their faces.
RowComponents row_components(const std::vector<std::uint8_t>& mask, Int3 size);

}  // namespace turgor

// Mask of the surroundings of a body in its CT. It is found once, when the body is built
// (build/surroundings.hpp). Nodes, drawn and measured surfaces, and deformed CTs use it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::lattice {

/// Kinds of a cell: what its voxels count as that are denser than air.
constexpr std::uint8_t kBodyCell = 0;     // as body
constexpr std::uint8_t kForeignCell = 1;  // as surroundings
constexpr std::uint8_t kContactCell = 2;  // as one or the other, by BodyVoxels: skin next to surroundings

/// Mask over cells of a few voxels each, i fastest. Without cells, a CT has no surroundings.
struct Surroundings {
  Int3 cell{1, 1, 1};                        // voxels per side
  Int3 size;                                 // cells
  std::vector<std::uint8_t> mask, row_mask;  // by cell; by row with any cell other than body

  bool has_row(int j, int k) const { return row_mask[std::size_t(k / cell.z * size.y + j / cell.y)] != 0; }
  /// Cells of the row that contains voxel row (j, k).
  const std::uint8_t* row(int j, int k) const {
    return mask.data() + std::size_t(k / cell.z * size.y + j / cell.y) * std::size_t(size.x);
  }
  std::uint8_t kind(Int3 voxel) const {
    return has_row(voxel.y, voxel.z) ? row(voxel.y, voxel.z)[voxel.x / cell.x] : kBodyCell;
  }
};

/// True if any voxel of a CT belongs to surroundings.
inline bool has_foreign(const Surroundings& surroundings) {
  return std::any_of(surroundings.row_mask.begin(), surroundings.row_mask.end(),
                     [](std::uint8_t row) { return row != 0; });
}

}  // namespace turgor::lattice

// What a CT shows beside the body: the table, a mattress's cover, a belt. It must be found before blocks of
// voxels are averaged: at coarse steps their means join it to the body.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/build/ct_part.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// The stored axis that leads from feet to head, nearly: along it a scan ends, across it are its four sides.
inline int long_axis(const Grid& grid) {
  int axis = 2;
  for (const int other : {1, 0})
    if (std::abs(grid.axes.column[other].z) > std::abs(grid.axes.column[axis].z)) axis = other;
  return axis;
}

/// Cells of a few voxels each, i fastest: what is known of a CT to tell the body from what lies beside it.
struct DenseCells {
  Int3 cell{1, 1, 1};                  // voxels a side
  Int3 size;                           // cells
  std::vector<std::uint8_t> any, all;  // 1 = of its voxels one is dense; all are
};
DenseCells make_dense_cells(const Grid& ct);
/// Fills these layers of cells, of which the part has all slices.
void pool_cells(const Exec& exec, const CtPart& ct, double air_max, Layers layers, DenseCells& cells);

/// The same cells: 1 where dense voxels do not belong to the body.
struct Surroundings {
  Int3 cell{1, 1, 1};                        // voxels a side
  Int3 size;                                 // cells
  std::vector<std::uint8_t> mask, row_mask;  // of cells; of rows that have any

  bool has_row(int j, int k) const { return row_mask[std::size_t(k / cell.z * size.y + j / cell.y)] != 0; }
  /// The cells of the row that voxel row (j, k) lies in.
  const std::uint8_t* row(int j, int k) const {
    return mask.data() + std::size_t(k / cell.z * size.y + j / cell.y) * std::size_t(size.x);
  }
};

/// The body is the largest part that holds together by more than some 3 mm. Beside it lies what is longer
/// than a hand, hangs on it by less than that, and is seen from the sides of the scan; ears and fingers stay.
Surroundings find_beside_body(const Exec& exec, const CtVolume& ct, double air_max);
Surroundings find_beside_body(const Exec& exec, const Grid& ct, const DenseCells& cells);

}  // namespace turgor::lattice

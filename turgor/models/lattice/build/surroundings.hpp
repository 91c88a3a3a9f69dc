// Surroundings of the body in a CT: table, mattress cover, belt. They are found before blocks of voxels are
// averaged, because coarse means would join them to the body.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/build/ct_part.hpp"
#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Stored axis that is closest to the direction from feet to head. A scan ends along it; the other two axes
/// have its four sides.
inline int long_axis(const Grid& grid) {
  int axis = 2;
  for (const int other : {1, 0})
    if (std::abs(grid.axes.column[other].z) > std::abs(grid.axes.column[axis].z)) axis = other;
  return axis;
}

/// Pooled cells of a few voxels each, i fastest, for the separation of body and surroundings.
struct DenseCells {
  Int3 cell{1, 1, 1};  // voxels per side
  Int3 size;           // cells
  // 1: at least one voxel is denser than air; all voxels are as dense as fat; at least one is denser than fat
  std::vector<std::uint8_t> any, all, dense;
};
DenseCells make_dense_cells(const Grid& ct);
/// Fills these layers of cells; `ct` must contain all their slices.
void pool_cells(const Exec& exec, const CtSlab& ct, double air_max, Layers layers, DenseCells& cells);

/// Finds the surroundings. The core of the body is the largest component connected by more than about 3 mm. A
/// component outside it is foreign if it is longer than a hand, connected to the body by less than that, and
/// mostly visible from the sides of the scan. Ears and fingers remain.
Surroundings find_surroundings(const Exec& exec, const CtVolume& ct, double air_max);
Surroundings find_surroundings(const Exec& exec, const Grid& ct, const DenseCells& cells);

/// CT values of the body. Foreign voxels are air. Next to them, the body is as dense as fat: it is the
/// opening of these voxels in their slice by a square of about 2 mm, which drops the cover of a mattress on
/// the skin. Values there are changed continuously, so that they pass the level of air where the CT passes
/// that of fat.
class BodyVoxels {
 public:
  BodyVoxels(const CtSlab& ct, const Surroundings& surroundings, double air_max);
  double operator()(Int3 voxel) const;  // [HU]

 private:
  bool is_dense(Int3 voxel) const;
  bool is_opened(Int3 voxel) const;
  bool is_beside_opened(Int3 voxel) const;  // in its slice
  double changed(double hu) const;

  CtSlab ct_;
  const Surroundings& surroundings_;
  double air_max_, fat_;  // levels [HU]
  Int3 square_;           // voxels per side of the opening
};

}  // namespace turgor::lattice

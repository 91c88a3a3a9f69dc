// Fixed-point voxel coordinates of nodes: integers in fractions of a voxel, so that rasterization is exact
// (kuhn_raster.hpp).
#pragma once

#include <algorithm>
#include <cmath>

#include "turgor/geometry/grid.hpp"
#include "turgor/geometry/kuhn_raster.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

struct VoxelCoordinates {
  Vec3d spacing;  // of the nodes [m]
  Mat3d to_out;   // from lattice frame [m] to voxels
  Vec3d origin;   // first node [voxels]
  int bits = 10;  // RasterWindow::bits

  TURGOR_HD Int3 operator()(Int3 node, Vec3 displacement) const {
    constexpr double kFarthest = 30000;  // clamp, beyond any grid [voxels]
    const Vec3d x = hadamard(Vec3d(node), spacing) + Vec3d(displacement);
    const Vec3d at = min(max(origin + to_out * x, Vec3d{-kFarthest, -kFarthest, -kFarthest}),
                         Vec3d{kFarthest, kFarthest, kFarthest}) *
                     double(1 << bits);
    return {int(lrint(at.x)), int(lrint(at.y)), int(lrint(at.z))};
  }
};

inline VoxelCoordinates voxel_coordinates(const Model& model, const Grid& out) {
  VoxelCoordinates to{.spacing = model.anatomy.grid.spacing,
                      .to_out = inverse(out.axes) * model.anatomy.grid.axes,
                      .origin = index_at(out, model.anatomy.grid.origin)};
  for (Vec3d& column : to.to_out.column)
    column = {column.x / out.spacing.x, column.y / out.spacing.y, column.z / out.spacing.z};
  return to;
}
/// -1 if the voxel axes are mirrored against the lattice axes.
inline double handedness(const VoxelCoordinates& to) { return determinant(to.to_out) < 0 ? -1 : 1; }

/// Volume ratio, deformed over rest, of a tetrahedron with det = 1 [1/units³].
inline double volume_ratio(const Model& model, const Grid& out, int bits) {
  const double units = double(1 << bits);
  return sample_volume(out) / sample_volume(model.anatomy.grid) / (units * units * units);
}

/// Finest fixed point in which no tetrahedron exceeds the range of exact arithmetic. No two nodes of a cell
/// move apart by more than the range [low, high] of all displacements, including 0.
inline int finest_bits(const VoxelCoordinates& to, Vec3 low, Vec3 high) {
  // largest extent of a cell [voxels]
  const Vec3d reach = to.spacing + Vec3d(high - low) * 3.0;
  double extent = 0;
  for (int row = 0; row < 3; row++) {
    double sum = 0;
    for (int column = 0; column < 3; column++) sum += std::abs(to.to_out.column[column][row]) * reach[column];
    extent = std::max(extent, sum);
  }
  int bits = 10;
  while (bits > 0 && extent * double(1 << bits) >= 0.9 * kLargestExtent) bits--;
  return bits;
}

}  // namespace turgor::lattice

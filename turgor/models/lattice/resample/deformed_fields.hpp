// Voxel fields of the deformed body other than HU: displacement to the rest position, and volume ratio. For
// host (resample.cpp) and device (device_resampling.hpp).
#pragma once

#include "turgor/geometry/grid.hpp"

namespace turgor::lattice {

/// Displacement from a voxel to the rest position of its tissue, patient frame [m].
struct DisplacementOfVoxel {
  Grid nodes, out;

  TURGOR_HD static Vec3 outside() { return {0, 0, 0}; }
  /// `at` is the rest position [nodes].
  TURGOR_HD Vec3 operator()(Int3 voxel, Vec3 at, float) const {
    return Vec3(point_at(nodes, Vec3d(at)) - point_at(out, Vec3d(voxel)));
  }
};

/// Volume ratio, deformed over rest.
struct JacobianOfVoxel {
  TURGOR_HD static float outside() { return 1; }
  TURGOR_HD float operator()(Int3, Vec3, float ratio) const { return ratio; }
};

}  // namespace turgor::lattice

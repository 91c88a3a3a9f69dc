// What a voxel of the deformed body says of its tissue, other than HU: where it came from, and how its volume
// has changed. Over plain values, for the CPU (resample.cpp) and for threads of a GPU
// (device_resampling.hpp).
#pragma once

#include "turgor/geometry/grid.hpp"

namespace turgor::lattice {

/// Where its tissue came from, minus where it is; patient frame [m].
struct DisplacementOfVoxel {
  Grid nodes, out;

  TURGOR_HD static Vec3 outside() { return {0, 0, 0}; }
  /// `at`: its place in the CT [nodes].
  TURGOR_HD Vec3 operator()(Int3 voxel, Vec3 at, float) const {
    return Vec3(point_at(nodes, Vec3d(at)) - point_at(out, Vec3d(voxel)));
  }
};

/// Volume now over volume in the CT.
struct JacobianOfVoxel {
  TURGOR_HD static float outside() { return 1; }
  TURGOR_HD float operator()(Int3, Vec3, float ratio) const { return ratio; }
};

}  // namespace turgor::lattice

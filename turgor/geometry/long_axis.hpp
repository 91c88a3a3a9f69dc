// Long axis of a label, from the moments of inertia of its voxels.
#pragma once

#include "turgor/geometry/volume.hpp"

namespace turgor {

/// Direction of the largest second moment of the voxels with a label, patient frame: a unit vector whose
/// largest component is positive. Zero without voxels.
Vec3d long_axis(const LabelVolume& labels, int label);

}  // namespace turgor

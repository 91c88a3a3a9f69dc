// Rotation vectors: the direction is the axis, the length is the angle.
#pragma once

#include "turgor/core/vec.hpp"

namespace turgor::haptics {

/// Rotation matrix of a rotation vector [rad].
Mat3d rotation(Vec3d turn);
/// Rotation vector of a matrix, no longer than π [rad].
Vec3d rotation_vector(const Mat3d& m);

}  // namespace turgor::haptics

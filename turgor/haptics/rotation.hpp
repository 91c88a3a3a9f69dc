// Rotations as vectors: the axis, as long as the angle is large.
#pragma once

#include "turgor/core/vec.hpp"

namespace turgor::haptics {

/// The rotation about `turn` by |turn| [rad].
Mat3d rotation(Vec3d turn);
/// Of a rotation: its axis times its angle, no longer than π [rad].
Vec3d rotation_vector(const Mat3d& m);

}  // namespace turgor::haptics

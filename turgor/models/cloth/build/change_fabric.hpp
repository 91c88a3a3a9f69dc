// Fabric of a cloth, changed after it was built.
#pragma once

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Builds the model again with a fabric of the same law and direction; positions, velocities and holds stay.
/// `triangles`: of the mesh as it was given to build. False, without a change, if the new model would number
/// its vertices or rows differently. For a model that is not on a device.
bool change_fabric(const Exec& exec, const Fabric& fabric, const std::vector<Int3>& triangles, Model& model,
                   State& state);

}  // namespace turgor::cloth

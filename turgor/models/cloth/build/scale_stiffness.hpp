// Stiffness of a whole cloth, scaled after it was built.
#pragma once

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Multiplies the stiffness of membrane, springs and bending by `factor` > 0. For a model that is not on a
/// device.
void scale_stiffness(double factor, Model& model);

}  // namespace turgor::cloth

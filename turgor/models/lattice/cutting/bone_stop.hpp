// Depth at which a blade meets bone.
#pragma once

#include <vector>

#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor::lattice {

/// Depth of the cut at each point of a path: BladePath::depth, or the depth at which the blade touches the
/// cell around a bone node at its current position, if that is less [m]. `tilt` is in radians. `halo` as in
/// Inputs.
std::vector<double> depths_above_bone(const Model& model, const Motion& motion, const BladePath& path,
                                      double tilt, const HaloExchange* halo);

}  // namespace turgor::lattice

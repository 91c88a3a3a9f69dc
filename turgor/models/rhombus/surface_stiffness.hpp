// Stiffness that varies over an organ's surface because of structures below: nodules, vessels, bone. Computed
// once, from a segmentation or from the CT.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "turgor/geometry/volume.hpp"
#include "turgor/models/rhombus/surface.hpp"

namespace turgor::rhombus {

/// Stiffness at each vertex, relative to the chain's. Layers below it, down to `depth` [m] along the normal,
/// act as springs in series with the stiffness `factor(position)`. Their weight decreases with depth.
/// Smoothed over neighbors, so that it does not show voxels.
std::vector<double> stiffness_below(const Surface& surface, double depth,
                                    const std::function<double(Vec3d)>& factor);

/// Factor of the label at a position; 1 for labels without one.
std::function<double(Vec3d)> factor_of_labels(const LabelVolume& labels, std::map<int, double> factors);
/// Factor of the CT value at a position, linear between the given values [HU] and constant beyond.
std::function<double(Vec3d)> factor_of_ct(const CtVolume& ct, std::map<double, double> factors);

}  // namespace turgor::rhombus

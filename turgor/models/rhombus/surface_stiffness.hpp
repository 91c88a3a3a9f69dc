// Stiffness that varies over an organ's surface because of what lies below: nodules, vessels, bone. Made
// once, from a segmentation or from the CT itself.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "turgor/geometry/volume.hpp"
#include "turgor/models/rhombus/surface.hpp"

namespace turgor::rhombus {

/// At each vertex, in multiples of the chain's: layers below it, down to `depth` [m] along the normal, are
/// springs in series, of `factor` at a place and the less important the deeper they lie. Smoothed over
/// neighbours, so that it does not show voxels.
std::vector<double> stiffness_below(const Surface& surface, double depth,
                                    const std::function<double(Vec3d)>& factor);

/// The factor of the label at a place; 1 where there is none.
std::function<double(Vec3d)> factor_of_labels(const LabelVolume& labels, std::map<int, double> factors);
/// The factor of the CT's value at a place, linear between the given values [HU] and constant beyond them.
std::function<double(Vec3d)> factor_of_ct(const CtVolume& ct, std::map<double, double> factors);

}  // namespace turgor::rhombus

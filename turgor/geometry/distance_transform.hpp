// Distances on grids: exact Euclidean distance transforms with spacing, and Gaussian smoothing.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// The distance of every sample's centre to the nearest centre of a sample that is set (nonzero) [m];
/// infinite when none is. [Felzenszwalb, Huttenlocher 2012]
std::vector<float> distance_transform(const Exec& exec, const Grid& grid,
                                      const std::vector<std::uint8_t>& set);

/// Smooths samples in place by a Gaussian of this standard deviation [m]. Samples beyond the grid are taken
/// for the nearest one of it.
void smooth_gaussian(const Exec& exec, const Grid& grid, double sigma, std::vector<float>& samples);

}  // namespace turgor

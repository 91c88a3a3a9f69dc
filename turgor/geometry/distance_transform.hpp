// Exact Euclidean distance transform on grids with spacing, and Gaussian smoothing.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// Distance from every sample center to the nearest center of a set (nonzero) sample [m]; infinite if no
/// sample is set. It takes the lower envelope of parabolas axis by axis. [Felzenszwalb, Huttenlocher 2012]
std::vector<float> distance_transform(const Exec& exec, const Grid& grid,
                                      const std::vector<std::uint8_t>& set);

/// Smooths samples in place by a Gaussian of this standard deviation [m]. Samples outside the grid have the
/// value of the nearest one inside.
void smooth_gaussian(const Exec& exec, const Grid& grid, double sigma, std::vector<float>& samples);

}  // namespace turgor

// A CT at half its resolution, smoothed: its gradients are the directions in which surfaces face, while those
// of the samples themselves show noise and the stairs of coarse grids.
#pragma once

#include "turgor/core/exec.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// Means over 2 × 2 × 2 samples, then weights 1 2 1 along every axis. Sample i lies at index 2 i + 1/2 of the
/// volume.
CtVolume smooth_half(const Exec& exec, const CtVolume& ct);

}  // namespace turgor

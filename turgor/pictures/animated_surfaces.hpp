// Surfaces of snapshots over time, for USD and glTF: bodies, walls of wounds, inclusions, tools, threads and
// obstacles.
#pragma once

#include "turgor/io/mesh/surface_animation.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// Appends the surfaces of a snapshot. A snapshot with the time of the latest one is ignored.
void add_surfaces(const WorldSnapshot& snapshot, SurfaceAnimation& animation);
/// Removes surfaces that are empty at all times.
void remove_empty_surfaces(SurfaceAnimation& animation);

}  // namespace turgor

// Bodies and tools in a recording: surfaces as pictures show them, and what every tool felt in every tick.
// Enough to draw and to plot a run again without its Green's functions.
#pragma once

#include <string>

#include "turgor/io/hdf5_file.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Of all bodies whose surface is kept, as they are shown; `snapshot` is the group of a snapshot.
Status write_surfaces(Hdf5File& file, const std::string& snapshot, const World& world);
/// Error: arrays are missing or of other sizes, or a triangle has a corner that is not there.
Status read_surfaces(const Hdf5File& file, const std::string& snapshot, World& world);

/// Samples of all tools, and every body when it was pressed most.
Status write_touch(Hdf5File& file, const World& world);
Status read_touch(const Hdf5File& file, World& world);

}  // namespace turgor

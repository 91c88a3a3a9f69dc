// Organs and tools in a recording: surfaces as pictures show them, and what every tool felt in every tick.
// Enough to draw and to plot a run again without its Green's functions.
#pragma once

#include <string>

#include "turgor/io/hdf5_file.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// `group` ends in a slash.
Status write_shown(Hdf5File& file, const std::string& group, const OrganSurface& surface);
/// Error: arrays are missing or of other sizes, or a triangle has a corner that is not there.
Result<OrganSurface> read_shown(const Hdf5File& file, const std::string& group, std::size_t tool_count);

/// Samples of all tools, and every organ when it was pressed most.
Status write_touch(Hdf5File& file, const World& world);
Status read_touch(const Hdf5File& file, World& world);

}  // namespace turgor

// Sutures in a recording: phase, lengths and tension of every stitch. Used by recording.cpp.
#pragma once

#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

Status write_suture(Hdf5File& file, const std::string& group, const Suture& suture);
/// Lays the stitches on the restored wound, and restores their state. Errors: damaged data.
Status read_suture_state(const Hdf5File& file, const std::string& group, const World& world, Suture& suture);

}  // namespace turgor

// Cloth in a recording: where every vertex is at each snapshot, in the numbering of the mesh.
#pragma once

#include <string>

#include "turgor/io/hdf5_file.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// `group` ends in a slash.
Status write_cloth(Hdf5File& file, const std::string& group, const ClothBody& body);
/// Error: another number of vertices, or a place that is no number.
Status read_cloth(const Hdf5File& file, const std::string& group, ClothBody& body);

}  // namespace turgor

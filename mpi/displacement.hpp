// Displacements at the nodes of a body as one MetaImage, to which every process writes its own layers.
#pragma once

#include <filesystem>

#include "mpi/exchange.hpp"

namespace turgor::mpi {

/// displacement.mhd and displacement.raw in a folder: three floats a node of the whole grid, patient frame
/// LPS [mm]; 0 outside of the body.
Status write_displacement(const PartOfBody& part, const Grid& nodes, const std::filesystem::path& folder);

}  // namespace turgor::mpi

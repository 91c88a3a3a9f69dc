// Displacements at the nodes of a body as one MetaImage; every process writes its own layers.
#pragma once

#include <filesystem>

#include "mpi/exchange.hpp"

namespace turgor::mpi {

/// Writes displacement.mhd and displacement.raw to a folder: three floats per node of the whole grid, patient
/// frame LPS [mm]; 0 outside of the body.
Status write_displacement(const Subdomain& subdomain, const Grid& nodes, const std::filesystem::path& folder);

}  // namespace turgor::mpi

// Checks of scenes for several processes.
#pragma once

#include "turgor/core/result.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor::mpi {

/// Error: names the first key that needs more than one lattice with incisions.
Status check_scene(const Scene& scene);

}  // namespace turgor::mpi

// What of a scene several processes can do together.
#pragma once

#include "turgor/core/result.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor::mpi {

/// Error: names the first key that asks for more than one lattice with incisions.
Status check_scene(const Scene& scene);

}  // namespace turgor::mpi

// Other cuts and stitches in a world that was loaded once.
#pragma once

#include "turgor/sim/world.hpp"

namespace turgor {

/// Loads the cuts and sutures of a scene into a world with its bodies at rest, in place of the world's own.
/// Errors: as load_cut and load_suture.
Status replace_cuts(const Scene& scene, World& world);

}  // namespace turgor

// Reads [excision.NAME]: center, size and time of a piece of skin that is cut out of a lattice.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

IncisionScene read_excision(SceneTable table, const std::string& name, const Scene& scene);

}  // namespace turgor

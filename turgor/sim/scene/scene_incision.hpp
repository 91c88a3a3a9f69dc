// Reads [incision.NAME]: path, depth and time of a cut of a lattice.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

IncisionScene read_incision(SceneTable table, const std::string& name, const Scene& scene);

}  // namespace turgor

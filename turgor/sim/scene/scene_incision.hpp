// Reads [incision.NAME]: path, depth and time of a cut of a lattice, and the undermining of cuts and
// excisions.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

IncisionScene read_incision(SceneTable table, const std::string& name, const Scene& scene);

/// Reads the table `undermine` of an incision or an excision, after the blade's depth.
void read_undermining(SceneTable& incision, lattice::Incision& blade);

}  // namespace turgor

// Reads the fixed vertices of a body: sides of its box, or a box.
#pragma once

#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// Key `fixed` of a body: one or several sides, or a table of sides and a depth, or of a box.
HeldBy read_held(SceneTable& body);

}  // namespace turgor

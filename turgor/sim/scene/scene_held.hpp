// Reading what holds a body from a scene: sides of its box, or a box.
#pragma once

#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// The key `fixed` of a body: the name of a side or several, or a table of sides and a depth, or of a box.
HeldBy read_held(SceneTable& body);

}  // namespace turgor

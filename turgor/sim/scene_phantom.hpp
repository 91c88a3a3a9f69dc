// { phantom = "torso", … } in a scene: a synthetic patient in place of a file.
#pragma once

#include "turgor/geometry/phantom.hpp"
#include "turgor/sim/scene_table.hpp"

namespace turgor {

PhantomParams read_phantom(SceneTable table);

}  // namespace turgor

// [output] and [camera.NAME] of a scene.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// After bodies, incisions and tools, whose files and pictures have names, too.
void read_cameras(SceneTable cameras, Scene& scene);
void read_output(SceneTable output, Scene& scene);

}  // namespace turgor

// Reads [output] and [camera.NAME].
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Requires that bodies, incisions and tools were read, whose names are also names of files and pictures.
void read_cameras(SceneTable cameras, Scene& scene);
void read_output(SceneTable output, Scene& scene);

}  // namespace turgor

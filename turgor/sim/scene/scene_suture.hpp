// Reads [suture.NAME]: a row of stitches or a single one, its thread, and its pull.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

SutureScene read_suture(SceneTable table, const std::string& name, const Scene& scene);

}  // namespace turgor

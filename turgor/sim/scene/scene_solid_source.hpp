// Reads the shape of a [body.NAME] with model = "sfem": a mesh, a surface, a label or a block.
#pragma once

#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// Adds a problem unless the table has exactly one shape.
SolidSource read_solid_source(SceneTable& body, SceneLabels& labels);

}  // namespace turgor

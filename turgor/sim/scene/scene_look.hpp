// Reads how bodies are drawn. Used by scene.cpp.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Reads `wet`, which bodies of every model have.
void read_wet(SceneTable& body, const std::string& name, LookScene& look);
/// Reads `cutaway` of [output].
void read_cutaway(SceneTable& output, Scene& scene);

}  // namespace turgor

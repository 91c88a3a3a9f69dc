// Parameters of a scene with their units and sources, for reports.
#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Numbers, choices and switches of bodies, tools, incisions and the world: those that the scene sets, and
/// the defaults of the numbers. `root` has the overrides; `problems` has the keys that were read.
std::vector<SceneParameter> scene_parameters(const toml::table& root, const SceneProblems& problems);

}  // namespace turgor

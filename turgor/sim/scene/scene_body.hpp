// Names of bodies in a scene. Used by scene_*.cpp.
#pragma once

#include <initializer_list>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Body named under a key, as in `body = "torso"`, of one of these models. Adds a problem if the scene has
/// none.
BodyId read_body(SceneTable& table, std::string_view key, const Scene& scene,
                 std::initializer_list<BodyKind> kinds);

/// Reads `stiffness_scale`, which bodies of every model have.
void read_stiffness_scale(SceneTable& body, double& scale);

}  // namespace turgor

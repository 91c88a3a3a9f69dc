// Which keys of a scene a world heeds while it moves, and how it takes them.
#pragma once

#include "turgor/sim/scene/scene_key.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Does a change of this key act at once? Else it does when the world is made anew.
bool changes_live(const SceneKey& key);

/// Takes from a scene, of which the world was made, what changes_live names. Nothing else of it moves.
void change_world(const Exec& exec, const Scene& scene, World& world);

}  // namespace turgor

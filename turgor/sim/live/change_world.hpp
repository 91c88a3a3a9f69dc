// Which keys of a scene a world heeds while it moves, and how it takes them.
#pragma once

#include <string>

#include "turgor/sim/scene/scene_key.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Why a change of this key of a scene acts only when the world is made anew: a few words. Empty: it acts at
/// once.
std::string why_not_live(const Scene& scene, const SceneKey& key);

/// The scene with another value of a key. Error: the scene's own sentence.
Result<Scene> with_change(const Scene& scene, const std::string& key, const std::string& value);

/// Takes from a scene what why_not_live lets pass. Nothing else of the world moves; what the scene says as it
/// did `before` leaves a wind that a hand made as it is.
void change_world(const Exec& exec, const Scene& before, const Scene& scene, World& world);

}  // namespace turgor

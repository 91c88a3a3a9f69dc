// Changes of scene keys in a running world. Keys that need a reload have a reason.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene_key.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// Reason why a change of this key needs a reload of the world, in a few words. Empty if the change acts
/// immediately.
std::string why_not_live(const Scene& scene, const SceneKey& key);

/// Scene with a new value of a key, or without a value for that of its text. Error: message of the scene's
/// reader.
Result<Scene> with_change(const Scene& scene, const std::string& key,
                          const std::optional<std::string>& value);
/// Value that an override gives to a key; empty: the scene's text counts.
std::optional<std::string> override_of(const std::vector<std::string>& overrides, const std::string& key);

/// Applies the values of all keys for which why_not_live is empty. Positions and velocities stay unchanged. A
/// wind set by a request stays if `scene` and `before` have the same wind.
void change_world(const Exec& exec, const Scene& before, const Scene& scene, World& world);

}  // namespace turgor

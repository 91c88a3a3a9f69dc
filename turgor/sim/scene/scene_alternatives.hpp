// Keys of a scene that stand for the same fact, such as a cut in meters and a cut in fractions.
#pragma once

#include <toml++/toml.h>

#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Removes the keys of the scene's text that overrides replace: `from` and `to` together replace
/// `from_fraction` and `to_fraction`, `block` replaces `spacing`, and `surface` replaces `labels` and
/// `label`. A pair that overrides set in part replaces nothing.
void replace_alternatives(toml::table& root, const SceneProblems& problems);

}  // namespace turgor

// Overrides of a scene's keys, as `--set key=value` gives them.
#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "turgor/core/result.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Puts `key=value` into the table, or removes the key if the value is empty. Adds a note when the key is an
/// old name. Error: invalid key, or a key that leads through a value that is not a table.
Status apply_override(toml::table& root, const std::string& text, SceneProblems& problems,
                      std::vector<std::string>& notes);

}  // namespace turgor

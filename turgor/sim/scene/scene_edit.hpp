// Edits of a scene's text that keep its comments and its order. Old names become current ones
// (scene_renamed.hpp).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"

namespace turgor {

/// Value of a key as TOML, such as "[0, 0, -9.81]": from the overrides, else from the text; empty if neither
/// sets it.
std::string scene_value(const Scene& scene, const std::string& key);

/// Scene text with `key=value` inserted: at the existing key, else as a new line of its table. Error: the
/// text is not TOML, or the key cannot be inserted.
Result<std::string> with_values(const std::string& text, const std::filesystem::path& file,
                                const std::vector<std::string>& overrides);

/// Tables [incision.NAME] for interactive cuts; the `name` of each cut is that of its body.
std::string incisions_text(const Scene& scene, std::span<const lattice::Incision> cuts);

}  // namespace turgor

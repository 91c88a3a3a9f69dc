// A scene's text with other values in it, as a person would have typed them: comments and order stay.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"

namespace turgor {

/// The value of a key as TOML says it, "[0, 0, -9.81]"; of the overrides when they name it, of the text else.
/// Empty: neither does.
std::string scene_value(const Scene& scene, const std::string& key);

/// The text with `key=value` put in, each where the text has that key, or else as a new line of its table.
/// Error: text that is no TOML, or an override that has no place in it.
Result<std::string> with_values(const std::string& text, const std::filesystem::path& file,
                                const std::vector<std::string>& overrides);

/// Tables [incision.NAME] for cuts that were made by hand, whose `name` is that of their body.
std::string incisions_text(const Scene& scene, std::span<const lattice::Incision> cuts);

}  // namespace turgor

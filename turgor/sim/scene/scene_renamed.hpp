// Old names of scene keys and values. They are accepted for one release, and each use adds a note to the
// scene. The tables in scene_renamed.cpp list them; remove an entry to end its support.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// One use of an old name: the note for the user, its region in the scene's text and the text to write there.
struct RenamedUse {
  std::string note;
  toml::source_region source;
  std::string replacement;
};

/// Replaces old names in `root` by the current ones, so that readers see current names only. Adds a problem
/// when a table has both names of a key; the current one stays.
std::vector<RenamedUse> rename_old_names(toml::table& root, SceneProblems& problems);

/// Current name of a dotted key, as --set gives it; adds a note when `key` is an old name. The model of a
/// body decides which names are old, hence `root`.
std::string current_key(const toml::table& root, const std::string& key, std::vector<std::string>& notes);

/// Scene text with current names; comments and order stay. Text that is not TOML is returned unchanged.
std::string with_current_names(std::string text, const std::filesystem::path& file);

/// Byte offset of a position that toml++ reports, which counts lines and UTF-8 characters from 1.
std::size_t offset_of(std::string_view text, toml::source_position position);

}  // namespace turgor

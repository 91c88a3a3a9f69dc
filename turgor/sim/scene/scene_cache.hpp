// Folders for caches between runs. A scene may choose only a folder below the user's cache folder, because it
// may come from another person; the command line may choose any folder.
#pragma once

#include <filesystem>

#include "turgor/core/result.hpp"

namespace turgor {

/// Cache folder of the user: $XDG_CACHE_HOME/turgor, else ~/.cache/turgor. Empty if neither is known.
std::filesystem::path user_cache_folder();

/// Folder for the text of a scene: a relative name is below the user's cache folder, and an absolute one must
/// be. Links are followed. Error: "a folder below …", the expected value.
Result<std::filesystem::path> cache_folder_of_scene(const std::filesystem::path& name);

}  // namespace turgor

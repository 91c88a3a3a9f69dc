#include "turgor/sim/scene/scene_cache.hpp"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// True if both are absolute and normal, and `path` is the folder or below it.
bool is_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

}  // namespace

fs::path user_cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "turgor";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "turgor";
  return {};
}

Result<fs::path> cache_folder_of_scene(const fs::path& name) {
  const fs::path user = user_cache_folder();
  if (user.empty()) return Error{"`false`, because neither XDG_CACHE_HOME nor HOME names a cache folder"};
  std::error_code error;
  const fs::path root = fs::weakly_canonical(fs::absolute(user, error), error);
  const fs::path folder = error ? fs::path() : fs::weakly_canonical(root / name, error);
  if (!error && is_below(folder, root)) return folder;
  return Error{fmt::format("a folder below the user's cache folder {}; only --set may choose another one",
                           user.string())};
}

}  // namespace turgor

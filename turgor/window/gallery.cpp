#include "turgor/window/gallery.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>
#include <system_error>

#include "turgor/io/files/file.hpp"

namespace turgor {

namespace fs = std::filesystem;

namespace {

bool has_scenes(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "palpation.toml", ignored);
}

}  // namespace

fs::path scene_folder() {
  if (const char* given = std::getenv("TURGOR_SCENES"); given && *given) return given;
  if (has_scenes("scenes")) return "scenes";
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  for (fs::path above = program.parent_path(); above.has_relative_path(); above = above.parent_path())
    for (const fs::path& folder : {above / "scenes", above / "share" / "turgor" / "scenes"})
      if (has_scenes(folder)) return folder;
  return {};
}

std::vector<GalleryScene> list_scenes(const fs::path& folder) {
  std::vector<GalleryScene> scenes;
  std::error_code failed;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const fs::path& file = at->path();
    if (file.extension() != ".toml") continue;
    const Result<std::string> text = read_file(file);
    if (!text) continue;
    const std::string stem = file.stem().string();
    scenes.push_back({file, title_of(stem), first_comment(*text), folder / "pictures" / (stem + ".png")});
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const GalleryScene& a, const GalleryScene& b) { return a.title < b.title; });
  return scenes;
}

std::string title_of(const std::string& stem) {
  std::string title = stem;
  std::replace(title.begin(), title.end(), '-', ' ');
  if (!title.empty()) title[0] = char(std::toupper(static_cast<unsigned char>(title[0])));
  return title;
}

std::string first_comment(const std::string& text) {
  std::istringstream lines(text);
  std::string comment;
  for (std::string line; std::getline(lines, line) && line.starts_with('#');) {
    const std::size_t begin = line.find_first_not_of("# ");
    if (begin == std::string::npos || line.find(": turgor ") != std::string::npos) break;
    comment += (comment.empty() ? "" : " ") + line.substr(begin);
  }
  std::erase(comment, '`');
  return comment;
}

}  // namespace turgor

// The scenes that come with the program, with a sentence and a picture each, for a window without a scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace turgor {

struct GalleryScene {
  std::filesystem::path file;
  std::string title, sentence;    // "Sheet on liver"; first sentences of the file's comment
  std::filesystem::path picture;  // a small PNG in the folder `pictures` beside the scene; may be missing
};

/// Folder of the scenes: $TURGOR_SCENES, or `scenes` in the current folder, in a folder above the program, or
/// in its share/turgor. Empty if no such folder exists.
std::filesystem::path scene_folder();

/// All scenes of a folder, by name.
std::vector<GalleryScene> list_scenes(const std::filesystem::path& folder);

/// "sheet-on-liver" → "Sheet on liver".
std::string title_of(const std::string& stem);
/// The comment at the start of a scene's text, without backticks, up to a line with a command.
std::string first_comment(const std::string& text);

}  // namespace turgor

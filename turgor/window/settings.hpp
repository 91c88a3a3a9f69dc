// Settings that the window remembers: its size, the side panel, the theme, the size of text and the files
// opened last. They are a small JSON file in the user's configuration folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// Colors of panels and text.
enum class Theme : std::uint8_t { kDark, kLight };

struct Appearance {
  Theme theme = Theme::kDark;
  float text_size = 16;  // height of a line of text before scaling to the monitor [pixels]

  bool operator==(const Appearance&) const = default;
};
constexpr float kSmallestText = 12, kLargestText = 28;  // [pixels]

/// Panels and sections of the side panel that are shown. The help is not remembered.
struct Panels {
  bool help = false, controls = true, parameters = false, curves = true, ct = false;
  float side_width = 320;  // of the side panel before scaling [pixels]
};

struct Settings {
  int width = 1280, height = 800;  // of the window [pixels]
  Appearance appearance;
  Panels panels;
  std::vector<std::filesystem::path> recent;  // scenes, latest first

  static constexpr std::size_t kMostRecent = 10;
};

/// File below $XDG_CONFIG_HOME or $HOME/.config. Empty if neither is set: nothing is remembered then.
std::filesystem::path settings_file();

/// The defaults if the file does not exist. Error: a file that is unreadable or no JSON. Values out of range
/// are replaced by their defaults.
Result<Settings> read_settings(const std::filesystem::path& file);
/// Creates the folder if necessary.
Status write_settings(const std::filesystem::path& file, const Settings& settings);

/// Puts a scene first in the list.
void add_recent(const std::filesystem::path& scene, Settings& settings);

}  // namespace turgor

#include "turgor/window/settings.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turgor/io/files/file.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Reads a number within limits; another value leaves the default.
template <class Number>
void take_number(const json& from, const char* key, Number low, Number high, Number& value) {
  if (!from.contains(key) || !from[key].is_number()) return;
  const auto read = from[key].get<double>();
  if (read >= double(low) && read <= double(high)) value = Number(read);
}

void take_flag(const json& from, const char* key, bool& value) {
  if (from.contains(key) && from[key].is_boolean()) value = from[key].get<bool>();
}

json json_of(const Settings& settings) {
  const Panels& panels = settings.panels;
  json recent = json::array();
  for (const fs::path& file : settings.recent) recent.push_back(file.string());
  return {{"width", settings.width},
          {"height", settings.height},
          {"theme", settings.appearance.theme == Theme::kLight ? "light" : "dark"},
          {"text_size", settings.appearance.text_size},
          {"side_panel", panels.controls},
          {"side_width", panels.side_width},
          {"parameters", panels.parameters},
          {"curves", panels.curves},
          {"ct", panels.ct},
          {"recent", recent}};
}

Settings settings_of(const json& from) {
  Settings settings;
  constexpr int kMostPixels = 16384;
  take_number(from, "width", 320, kMostPixels, settings.width);
  take_number(from, "height", 240, kMostPixels, settings.height);
  if (from.contains("theme") && from["theme"] == "light") settings.appearance.theme = Theme::kLight;
  take_number(from, "text_size", kSmallestText, kLargestText, settings.appearance.text_size);
  Panels& panels = settings.panels;
  take_flag(from, "side_panel", panels.controls);
  take_number(from, "side_width", 100.0f, 4000.0f, panels.side_width);
  take_flag(from, "parameters", panels.parameters);
  take_flag(from, "curves", panels.curves);
  take_flag(from, "ct", panels.ct);
  if (from.contains("recent") && from["recent"].is_array())
    for (const json& file : from["recent"])
      if (file.is_string() && settings.recent.size() < Settings::kMostRecent)
        settings.recent.emplace_back(file.get<std::string>());
  return settings;
}

}  // namespace

fs::path settings_file() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && *config)
    return fs::path(config) / "turgor" / "window.json";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".config" / "turgor" / "window.json";
  return {};
}

Result<Settings> read_settings(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return Settings();
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  const json read = json::parse(*text, nullptr, false);
  if (!read.is_object())
    return Error{fmt::format("{}: expected a JSON object, found other text", file.string())};
  return settings_of(read);
}

Status write_settings(const fs::path& file, const Settings& settings) {
  std::error_code ignored;  // write_file reports errors
  fs::create_directories(file.parent_path(), ignored);
  return write_file(file, json_of(settings).dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

void add_recent(const fs::path& scene, Settings& settings) {
  std::error_code ignored;
  const fs::path absolute = fs::absolute(scene, ignored).lexically_normal();
  std::erase(settings.recent, absolute);
  settings.recent.insert(settings.recent.begin(), absolute);
  if (settings.recent.size() > Settings::kMostRecent) settings.recent.resize(Settings::kMostRecent);
}

}  // namespace turgor

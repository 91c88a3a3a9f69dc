// A key of a scene, as its reader states it: unit, what holds without it, which numbers are allowed, what it
// means. docs/scene.md is made of these, and whoever offers a key to be changed finds its limits here.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace turgor {

/// Which numbers are allowed, and their unit in error messages.
struct Allowed {
  double low = -std::numeric_limits<double>::max(), high = std::numeric_limits<double>::max();
  bool open = false;  // are the limits themselves refused?
  const char* unit = "";
};
inline Allowed any_number(const char* unit) { return {.unit = unit}; }
inline Allowed positive(const char* unit) { return {.low = 0, .open = true, .unit = unit}; }
inline Allowed not_negative(const char* unit) { return {.low = 0, .unit = unit}; }
inline Allowed within(double low, double high, const char* unit = "") {
  return {.low = low, .high = high, .unit = unit};
}
inline Allowed inside(double low, double high, const char* unit = "") {
  return {.low = low, .high = high, .open = true, .unit = unit};
}
/// "from 0 to 1", "above 0"; empty without limits.
std::string limits_text(const Allowed& allowed);

/// A sentence about a key, and what holds without it where that is not the value the reader starts from.
struct Meaning {
  Meaning(const char* sentence, const char* without = nullptr)  // NOLINT(google-explicit-constructor)
      : text(sentence), fallback(without) {}
  const char* text;
  const char* fallback;
};

struct SceneKey {
  std::string path;            // "body.torso.skin.shear"
  std::string group, key;      // "lattice", "skin.shear": where docs/scene.md lists it
  std::string unit, fallback;  // "N/m", "100"
  Allowed allowed;             // of numbers
  std::string meaning;
  bool is_whole = false;  // a whole number
};

/// The keys that a scene has or could have: what its text is asked for while it is read. A scene with errors
/// has them, too; one that is no TOML has none.
std::vector<SceneKey> scene_keys(std::string_view text, const std::filesystem::path& file);

}  // namespace turgor

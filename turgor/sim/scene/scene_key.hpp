// Description of a scene key by its reader: unit, default, allowed numbers and meaning. docs/scene.md is
// generated from it, and the window takes the limits of its controls from it.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace turgor {

/// Allowed numbers, and their unit in error messages. Numbers whose magnitude single precision rounds to 0 or
/// to infinity are never allowed.
struct Allowed {
  double low = -std::numeric_limits<double>::max(), high = std::numeric_limits<double>::max();
  bool open = false;  // true if the limits themselves are excluded
  const char* unit = "";
};

/// Largest magnitude of a number without a narrower range, and the reciprocal of the smallest. Products of
/// three such numbers, as in the determinant of a stiffness, fit in single precision (1e-38 to 3e38).
constexpr double kLargestNumber = 1e12;

inline Allowed any_number(const char* unit) {
  return {.low = -kLargestNumber, .high = kLargestNumber, .unit = unit};
}
inline Allowed positive(const char* unit) {
  return {.low = 1 / kLargestNumber, .high = kLargestNumber, .unit = unit};
}
inline Allowed not_negative(const char* unit) { return {.low = 0, .high = kLargestNumber, .unit = unit}; }
inline Allowed within(double low, double high, const char* unit = "") {
  return {.low = low, .high = high, .unit = unit};
}
inline Allowed inside(double low, double high, const char* unit = "") {
  return {.low = low, .high = high, .open = true, .unit = unit};
}
/// Young's moduli. Compliances of bodies of any size fit in single precision with them.
inline Allowed modulus() { return within(1e-3, kLargestNumber, "Pa"); }
/// "from 0 to 1", "between 0 and 1"; empty without limits.
std::string limits_text(const Allowed& allowed);

/// Meaning of a key, and its default if that is not the reader's initial value.
struct Meaning {
  Meaning(const char* sentence, const char* without = nullptr)  // NOLINT(google-explicit-constructor)
      : text(sentence), fallback(without) {}
  const char* text;
  const char* fallback;
};

struct SceneKey {
  std::string path;            // "body.torso.skin.shear"
  std::string group, key;      // group of docs/scene.md, and path in it
  std::string unit, fallback;  // "N/m", "100"
  Allowed allowed;             // limits of numbers
  std::string meaning;
  bool is_whole = false;  // a whole number
};

/// Keys that the readers read from this scene, whether present or not. A scene with errors has keys too; a
/// text that is not TOML has none.
std::vector<SceneKey> scene_keys(std::string_view text, const std::filesystem::path& file);

}  // namespace turgor

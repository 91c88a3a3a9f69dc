// Typed reading of one TOML table: every value is asked for by key, checked, and complained about with its
// place; keys that nobody asked for are errors with a suggestion. Used by scene.cpp alone.
#pragma once

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "turgor/core/vec.hpp"
#include "turgor/sim/scene/nearest_name.hpp"

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

/// What is wrong with a scene, and where its values came from.
struct SceneProblems {
  std::string file;
  std::filesystem::path folder;                  // of relative paths in the file
  std::map<std::string, std::string> overrides;  // dotted key -> the text given to --set
  struct Problem {
    unsigned line;
    std::string message;
    friend auto operator<=>(const Problem&, const Problem&) = default;
  };
  std::set<Problem> problems;

  /// The override that set this key or a table around it, or "".
  std::string override_of(const std::string& path) const;
  /// "FILE:LINE:COLUMN", or "--set KEY" when the value came from there.
  std::string place_of(const std::string& path, const toml::node& node) const;
  void add(const std::string& path, const toml::node& node, const std::string& what);
};

/// A value as an error message shows it: the number 3, the text "x", a table.
std::string describe(const toml::node& node);

class SceneTable {
 public:
  SceneTable(const toml::table& table, std::string path, SceneProblems& problems)
      : table_(table), path_(std::move(path)), problems_(problems) {}

  /// These leave `value` alone when the key is missing or wrong, and note what was wrong.
  void read(std::string_view key, double& value, const Allowed& allowed);
  void read(std::string_view key, int& value, const Allowed& allowed);
  void read(std::string_view key, bool& value);
  void read(std::string_view key, std::string& value);
  void read(std::string_view key, Vec3d& value, const Allowed& allowed);
  void read(std::string_view key, Int3& value, const Allowed& allowed);
  /// A file's name; relative ones are relative to the scene's folder, from --set to the current folder.
  void read_path(std::string_view key, std::filesystem::path& value);
  template <class T>
  void read_choice(std::string_view key, T& value, const std::vector<std::pair<std::string, T>>& choices);
  void read_choice(std::string_view key, std::string& value, const std::vector<std::string>& choices);

  /// The value under `key`, for keys that take several shapes; null when missing.
  const toml::node* find(std::string_view key);
  /// A table inside this one; an empty one when missing.
  SceneTable table(std::string_view key);
  /// All keys, in the order of the file.
  std::vector<std::string> keys() const;
  /// The same for tables whose keys name things; notes those that are no names (name.hpp).
  std::vector<std::string> names();
  bool has(std::string_view key) const { return table_.contains(key); }

  /// Numbers of an array, converted and checked; empty and a note when it is not such an array.
  std::vector<double> numbers(std::string_view key, const toml::node& node, const Allowed& allowed);
  /// Notes a problem with a key, or, when it is missing, with the table.
  void fail(std::string_view key, const std::string& what);
  /// Notes "expected …, found …" about a value.
  void fail_value(std::string_view key, const toml::node& node, const std::string& expected);
  /// Notes that one of `keys` is needed, unless the table has one.
  void require(const std::vector<std::string>& keys, const std::string& what_for);
  /// "FILE:LINE:COLUMN: path" of this table.
  std::string place() const { return problems_.place_of(path_, table_) + ": " + path_; }
  /// Notes every key that was never asked for. Call last.
  void finish();

 private:
  std::string path_of(std::string_view key) const;

  const toml::table& table_;
  std::string path_;
  SceneProblems& problems_;
  std::vector<std::string> known_;
  std::vector<std::string> missing_;
};

template <class T>
void SceneTable::read_choice(std::string_view key, T& value,
                             const std::vector<std::pair<std::string, T>>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, meaning] : choices) names.push_back(name);
  std::string chosen;
  for (const auto& [name, meaning] : choices)
    if (meaning == value) chosen = name;
  read_choice(key, chosen, names);
  for (const auto& [name, meaning] : choices)
    if (name == chosen) value = meaning;
}

}  // namespace turgor

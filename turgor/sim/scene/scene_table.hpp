// Typed reading of one TOML table: every value is asked for by key, checked, and complained about with its
// place; keys that nobody asked for are errors with a suggestion. Whoever asks says what the key means
// (scene_key.hpp). Used by scene*.cpp.
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
#include "turgor/sim/scene/scene_key.hpp"

namespace turgor {

/// What is wrong with a scene, where its values came from and, when that is wanted, what it was asked for.
struct SceneProblems {
  std::string file;
  std::filesystem::path folder;                  // of relative paths in the file
  std::map<std::string, std::string> overrides;  // dotted key -> the text given to --set
  std::filesystem::path override_folder;         // of relative paths in those; empty = the current one
  struct Problem {
    unsigned line;
    std::string message;
    friend auto operator<=>(const Problem&, const Problem&) = default;
  };
  std::set<Problem> problems;
  bool lists_keys = false;
  std::vector<SceneKey> keys;

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
  void read(std::string_view key, double& value, const Allowed& allowed, Meaning meaning);
  void read(std::string_view key, int& value, const Allowed& allowed, Meaning meaning);
  void read(std::string_view key, bool& value, Meaning meaning);
  void read(std::string_view key, std::string& value, Meaning meaning);
  void read(std::string_view key, Vec3d& value, const Allowed& allowed, Meaning meaning);
  void read(std::string_view key, Int3& value, const Allowed& allowed, Meaning meaning);
  /// A file's name; relative ones are relative to the scene's folder, from --set to the current folder.
  void read_path(std::string_view key, std::filesystem::path& value, Meaning meaning);
  template <class T>
  void read_choice(std::string_view key, T& value, const std::vector<std::pair<std::string, T>>& choices,
                   Meaning meaning);
  void read_choice(std::string_view key, std::string& value, const std::vector<std::string>& choices,
                   Meaning meaning);

  /// The value under `key`, for keys that take several shapes; null when missing. Those need a sentence of
  /// their own: describe.
  const toml::node* find(std::string_view key);
  void describe(std::string_view key, const char* unit, const char* fallback, const char* meaning,
                const Allowed& allowed = {});
  /// A table inside this one; an empty one when missing.
  SceneTable table(std::string_view key);
  /// The same for a table that a name of the scene's stands for; "NAME" in the list of keys.
  SceneTable named(std::string_view name);
  /// From here on keys are listed in a group of their own.
  void begin_group(const char* group) { group_ = group, snapshot_.clear(); }
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
  /// The same about a number, with what was likely meant by a length in millimetres.
  void fail_number(std::string_view key, const toml::node& node, const std::string& expected,
                   const Allowed& allowed);
  /// Notes that one of `keys` is needed, unless the table has one.
  void require(const std::vector<std::string>& keys, const std::string& what_for);
  /// "FILE:LINE:COLUMN: path" of this table.
  std::string place() const { return problems_.place_of(path_, table_) + ": " + path_; }
  /// Notes every key that was never asked for. Call last.
  void finish();

 private:
  std::string path_of(std::string_view key) const;
  SceneTable inner(std::string_view key, std::string_view snapshot);
  void list(std::string_view key, const Allowed& allowed, const std::string& fallback, Meaning meaning,
            bool is_whole = false);

  const toml::table& table_;
  std::string path_;
  SceneProblems& problems_;
  std::vector<std::string> known_;
  std::vector<std::string> missing_;
  std::set<std::string, std::less<>> required_;
  std::string group_, snapshot_;  // of the list of keys: where this table is, and its path from there
};

template <class T>
void SceneTable::read_choice(std::string_view key, T& value,
                             const std::vector<std::pair<std::string, T>>& choices, Meaning meaning) {
  std::vector<std::string> names;
  for (const auto& [name, choice] : choices) names.push_back(name);
  std::string chosen;
  for (const auto& [name, choice] : choices)
    if (choice == value) chosen = name;
  read_choice(key, chosen, names, meaning);
  for (const auto& [name, choice] : choices)
    if (name == chosen) value = choice;
}

}  // namespace turgor

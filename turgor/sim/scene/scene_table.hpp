// Typed reading of one TOML table. Each value is read by key and checked; an error names its source location.
// A key that no reader read is an error with a suggestion. Readers state the meaning of each key
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

/// Problems of a scene, the sources of its values and, on request, the list of keys that were read.
struct SceneProblems {
  std::string file;
  std::filesystem::path folder;                  // base of relative paths in the file
  std::map<std::string, std::string> overrides;  // dotted key -> text given to --set
  /// Base of relative paths in the overrides of a recording; empty = the current folder and no recording.
  std::filesystem::path override_folder;
  struct Problem {
    unsigned line;
    std::string message;
    friend auto operator<=>(const Problem&, const Problem&) = default;
  };
  std::set<Problem> problems;
  std::vector<std::string> notes;  // for the user: values that were replaced
  bool lists_keys = false;
  std::vector<SceneKey> keys;

  /// Override that set this key or an enclosing table, or "".
  std::string override_of(const std::string& path) const;
  /// "FILE:LINE:COLUMN", or "--set KEY" if an override set the value.
  std::string location_of(const std::string& path, const toml::node& node) const;
  void add(const std::string& path, const toml::node& node, const std::string& what);
};

/// Value as error messages show it: the number 3, the text "x", a table; "an array" for one of more than
/// `longest` characters.
std::string describe(const toml::node& node, std::size_t longest = 60);

class SceneTable {
 public:
  SceneTable(const toml::table& table, std::string path, SceneProblems& problems)
      : table_(table), path_(std::move(path)), problems_(problems) {}

  /// These leave `value` unchanged if the key is missing or wrong, and add a problem if it is wrong.
  void read(std::string_view key, double& value, const Allowed& allowed, Meaning meaning);
  void read(std::string_view key, int& value, const Allowed& allowed, Meaning meaning);
  void read(std::string_view key, bool& value, Meaning meaning);
  void read(std::string_view key, std::string& value, Meaning meaning);
  void read(std::string_view key, Vec3d& value, const Allowed& allowed, Meaning meaning);
  void read(std::string_view key, Int3& value, const Allowed& allowed, Meaning meaning);
  /// File name. Relative names are relative to the scene's folder, or with --set to the current folder.
  void read_path(std::string_view key, std::filesystem::path& value, Meaning meaning);
  /// Folder of a cache, which a scene may choose only below the user's cache folder (scene_cache.hpp). With
  /// --set it is any folder. A recording that chooses another folder gets the user's, and a note.
  void read_cache_folder(std::string_view key, std::filesystem::path& value, Meaning meaning);
  template <class T>
  void read_choice(std::string_view key, T& value, const std::vector<std::pair<std::string, T>>& choices,
                   Meaning meaning);
  void read_choice(std::string_view key, std::string& value, const std::vector<std::string>& choices,
                   Meaning meaning);

  /// Value under `key`, for keys that accept several types; null if missing. Such a key also needs
  /// describe().
  const toml::node* find(std::string_view key);
  void describe(std::string_view key, const char* unit, const char* fallback, const char* meaning,
                const Allowed& allowed = {});
  /// Table inside this one; empty if missing.
  SceneTable table(std::string_view key);
  /// Tables of an array; empty if missing. Another value adds a problem. To list the keys of such tables, the
  /// result has one empty table when keys are listed (is_listed).
  std::vector<SceneTable> tables(std::string_view key);
  /// True for a table that only lists its keys.
  bool is_listed() const { return is_listed_; }
  /// The same for a table whose short form is a text; empty if the value is one.
  SceneTable table_or_text(std::string_view key);
  /// The same for a table with a user-defined name; the list of keys shows "NAME".
  SceneTable named(std::string_view name);
  /// Starts a new group in the list of keys.
  void begin_group(const char* group) { group_ = group, group_path_.clear(); }
  /// All keys, in the order of the file.
  std::vector<std::string> keys() const;
  /// The same for tables whose keys are user-defined names; adds a problem for invalid names (name.hpp).
  std::vector<std::string> names();
  bool has(std::string_view key) const { return table_.contains(key); }
  /// Number of problems of the whole scene so far.
  std::size_t problem_count() const { return problems_.problems.size(); }

  /// Numbers of an array, checked. Empty, and a problem, if the value is no such array.
  std::vector<double> numbers(std::string_view key, const toml::node& node, const Allowed& allowed);
  /// Adds a problem for a key, or for the table if the key is missing.
  void fail(std::string_view key, const std::string& what);
  /// Adds the problem "expected …, found …" for a value.
  void fail_value(std::string_view key, const toml::node& node, const std::string& expected);
  /// The same for a name; suggests the nearest of `names`.
  void fail_name(std::string_view key, const toml::node& node, const std::string& expected,
                 const std::vector<std::string>& names);
  /// The same for a number; suggests meters if a length was probably given in millimeters.
  void fail_number(std::string_view key, const toml::node& node, const std::string& expected,
                   const Allowed& allowed);
  /// Adds a problem unless the table has one of `keys`.
  void require(const std::vector<std::string>& keys, const std::string& what_for);
  /// "FILE:LINE:COLUMN: path" of this table.
  std::string location() const { return problems_.location_of(path_, table_) + ": " + path_; }
  /// Adds a problem for every key that was not read. Call last.
  void finish();

 private:
  std::string path_of(std::string_view key) const;
  SceneTable inner(std::string_view key, std::string_view listed_as);
  void list(std::string_view key, const Allowed& allowed, const std::string& fallback, Meaning meaning,
            bool is_whole = false);

  const toml::table& table_;
  std::string path_;
  SceneProblems& problems_;
  std::vector<std::string> known_;
  std::vector<std::string> missing_;
  std::set<std::string, std::less<>> required_;
  bool is_listed_ = false;
  std::string group_, group_path_;  // group in the list of keys, and this table's path in it
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

#include "turgor/sim/scene/scene_alternatives.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace turgor {

namespace {

/// Keys that overrides set together, and keys that have no meaning without them.
struct KeySet {
  std::vector<const char*> keys, dependent;
};

/// Sets of keys in tables of this kind; one set excludes the others.
struct Alternatives {
  const char* kind;
  std::vector<KeySet> sets;
};

const std::vector<Alternatives>& all_alternatives() {
  static const std::vector<Alternatives> kAll{
      {"incision",
       {{{"from", "to"}},
        {{"path"}},
        {{"from_fraction", "to_fraction"}},
        {{"path_fraction"}},
        {{"markups"}}}},
      {"excision", {{{"center"}}, {{"center_fraction"}}, {{"markups"}}}},
      {"body", {{{"spacing"}}, {{"block"}}}},
      {"body", {{{"mesh"}}, {{"sheet"}}, {{"surface"}}, {{"labels"}, {"label"}}}},
  };
  return kAll;
}

void replace_in(toml::table& table, const std::string& path, const std::vector<KeySet>& sets,
                const SceneProblems& problems) {
  const auto is_set = [&](const char* key) { return problems.overrides.contains(path + "." + key); };
  const auto chosen = std::find_if(sets.begin(), sets.end(), [&](const KeySet& set) {
    return std::all_of(set.keys.begin(), set.keys.end(), is_set);
  });
  if (chosen == sets.end()) return;
  for (auto other = sets.begin(); other != sets.end(); ++other)
    for (const auto* keys : {&other->keys, &other->dependent})
      for (const char* key : *keys)
        if (other != chosen && !is_set(key)) table.erase(key);
}

}  // namespace

void replace_alternatives(toml::table& root, const SceneProblems& problems) {
  for (const Alternatives& alternatives : all_alternatives()) {
    toml::table* named = root[alternatives.kind].as_table();
    if (!named) continue;
    for (auto&& [name, node] : *named)
      if (toml::table* table = node.as_table())
        replace_in(*table, std::string(alternatives.kind) + "." + std::string(name.str()), alternatives.sets,
                   problems);
  }
}

}  // namespace turgor

#include "turgor/sim/scene/scene_parameters.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

#include <fmt/format.h>

#include "turgor/sim/scene/scene_path.hpp"

namespace turgor {

namespace {

constexpr std::size_t kLongest = 200;  // characters of a value

bool is_physical(const std::string& path) {
  for (const char* table : {"body.", "tool.", "incision.", "excision.", "attachment.", "contact.", "world."})
    if (path.starts_with(table)) return true;
  return false;
}

/// Node of a dotted path; null if missing.
const toml::node* node_at(const toml::table& root, std::string_view path) {
  const toml::table* table = &root;
  for (;;) {
    const std::size_t dot = path.find('.');
    const toml::node* node = find_node(*table, path.substr(0, dot));
    if (dot == path.npos || !node) return node;
    if (!node->is_table()) return nullptr;
    table = node->as_table();
    path.remove_prefix(dot + 1);
  }
}

/// Default as documents show it, without the marks of code.
std::string plain_default(const SceneKey& key) {
  std::string text = key.fallback;
  std::erase(text, '`');
  return text;
}

bool is_number(std::string_view text) {
  return !text.empty() &&
         (std::isdigit(static_cast<unsigned char>(text[0])) || text[0] == '-' || text[0] == '[');
}

/// "scene.toml, line 7" or "--set KEY".
std::string source_of(const std::string& path, const toml::node& node, const SceneProblems& problems) {
  if (const std::string key = problems.override_of(path); !key.empty()) return "--set " + key;
  const auto line = node.source().begin.line;
  return line ? fmt::format("scene, line {}", line) : std::string("scene");
}

}  // namespace

std::vector<SceneParameter> scene_parameters(const toml::table& root, const SceneProblems& problems) {
  std::vector<SceneParameter> parameters;
  for (const SceneKey& key : problems.keys) {
    if (!is_physical(key.path)) continue;
    const toml::node* node = node_at(root, key.path);
    if (node && !node->is_table())
      parameters.push_back(
          {key.path, describe(*node, kLongest), key.unit, source_of(key.path, *node, problems)});
    // a default in voxels is no length, and stands back where a length is given
    else if (!node && is_number(plain_default(key)) && key.unit != "voxels")
      parameters.push_back({key.path, plain_default(key), key.unit, "default"});
  }
  return parameters;
}

}  // namespace turgor

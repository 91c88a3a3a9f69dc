#include "turgor/sim/scene/scene_overrides.hpp"

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "turgor/sim/scene/name.hpp"
#include "turgor/sim/scene/scene_path.hpp"
#include "turgor/sim/scene/scene_renamed.hpp"

namespace turgor {

namespace {

/// Value of an override as TOML; a bare word is text.
toml::table parse_override_value(const std::string& text) {
  try {
    toml::table parsed = toml::parse("value = " + text);
    if (parsed.size() == 1) return parsed;
  } catch (const toml::parse_error&) {
  }
  return toml::table{{"value", text}};
}

std::vector<std::string> split_key(std::string_view key) {
  std::vector<std::string> names(1);
  for (const char c : key) {
    if (c == '.')
      names.emplace_back();
    else
      names.back() += c;
  }
  return names;
}

std::vector<std::string> keys_of(const toml::table& table) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : table) keys.emplace_back(key.str());
  return keys;
}

/// Removes a key, as if the scene did not contain it.
Status remove_key(toml::table& table, const std::string& name, const std::string& key) {
  if (table.erase(name) > 0) return Done{};
  return Error{fmt::format("--set {}=: the scene has no {} that could be removed{}", key, key,
                           suggestion(name, keys_of(table)))};
}

Error no_element(const std::string& key, const std::string& path) {
  return Error{
      fmt::format("--set {}: the scene has no {}; the first element of an array has the index 0", key, path)};
}

/// Replaces an element of an array. False if the array has no such element.
bool replace_element(toml::table& table, IndexedName name, const toml::node& value) {
  const std::size_t index = name.indices.back();
  name.indices.pop_back();
  toml::node* node = find_node(table, name);
  toml::array* array = node ? node->as_array() : nullptr;
  if (!array || index >= array->size()) return false;
  array->replace(array->cbegin() + std::ptrdiff_t(index), value);
  return true;
}

}  // namespace

Status apply_override(toml::table& root, const std::string& text, SceneProblems& problems,
                      std::vector<std::string>& notes) {
  // key and value
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return Error{fmt::format("--set {}: expected key=value, as in --set body.torso.spacing=0.004", text)};
  const std::string key = current_key(root, text.substr(0, equals), notes), value = text.substr(equals + 1);
  const std::vector<std::string> names = split_key(key);
  std::vector<IndexedName> indexed;
  for (const std::string& name : names) {
    const std::optional<IndexedName> split = indexed_name(name);
    if (!split || !is_name(split->name))
      return Error{fmt::format("--set {}: expected a key of names with dots between them", key)};
    indexed.push_back(*split);
  }

  // table of the key
  toml::table* table = &root;
  std::string path;
  for (std::size_t i = 0; i + 1 < names.size(); i++) {
    // Overrides cannot create bodies, incisions or tools: a misspelt name would be ignored silently.
    const bool names_one = i == 1 && (names[0] == "body" || names[0] == "incision" ||
                                      names[0] == "excision" || names[0] == "suture" || names[0] == "tool" ||
                                      names[0] == "attachment" || names[0] == "contact");
    if (names_one && !table->contains(names[i]))
      return Error{fmt::format("--set {}: the scene has no {} {}{}", key, names[0], names[i],
                               suggestion(names[i], keys_of(*table)))};
    path += (i ? "." : "") + names[i];
    toml::node* next = find_node(*table, indexed[i]);
    if (!next && !indexed[i].indices.empty()) return no_element(key, path);
    if (!next) next = &table->insert(names[i], toml::table{}).first->second;
    if (!next->is_table())
      return Error{fmt::format("--set {}: {} is {} in the scene, not a table", key, path, describe(*next))};
    table = next->as_table();
  }

  // remove or set
  if (value.empty()) return remove_key(*table, names.back(), key);
  toml::table parsed = parse_override_value(value);
  if (!indexed.back().indices.empty()) {
    if (!replace_element(*table, indexed.back(), *parsed.get("value"))) return no_element(key, key);
  } else {
    table->insert_or_assign(names.back(), std::move(*parsed.get("value")));
  }
  problems.overrides[key] = value;
  return Done{};
}

}  // namespace turgor

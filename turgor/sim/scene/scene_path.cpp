#include "turgor/sim/scene/scene_path.hpp"

#include <algorithm>

namespace turgor {

std::optional<IndexedName> indexed_name(std::string_view text) {
  IndexedName found{std::string(text.substr(0, text.find('['))), {}};
  text.remove_prefix(found.name.size());
  constexpr std::size_t kMostDigits = 3;
  while (!text.empty()) {
    // "[12]"
    const std::size_t end = text.find(']');
    if (text[0] != '[' || end == text.npos || end < 2 || end > kMostDigits + 1) return std::nullopt;
    const std::string digits(text.substr(1, end - 1));
    if (!std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; }))
      return std::nullopt;
    found.indices.push_back(std::size_t(std::stoi(digits)));
    text.remove_prefix(end + 1);
  }
  return found;
}

toml::node* find_node(toml::table& table, const IndexedName& name) {
  toml::node* node = table.get(name.name);
  for (const std::size_t index : name.indices) {
    toml::array* array = node ? node->as_array() : nullptr;
    node = array ? array->get(index) : nullptr;
  }
  return node;
}

const toml::node* find_node(const toml::table& table, std::string_view name) {
  const std::optional<IndexedName> split = indexed_name(name);
  return split ? find_node(const_cast<toml::table&>(table), *split) : nullptr;
}

}  // namespace turgor

// Paths of scene keys: names with dots between them. A name may have indices of arrays:
// "body.arm.layers[0].young", "viscosity.pairs[1]".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

namespace turgor {

/// Name and indices: "layers" and {0}.
struct IndexedName {
  std::string name;
  std::vector<std::size_t> indices;
};
/// Empty if the brackets of a text do not hold whole numbers below 1000.
std::optional<IndexedName> indexed_name(std::string_view text);

/// TOML node under a name with indices, such as layers[1].young; null if the table lacks it.
toml::node* find_node(toml::table& table, const IndexedName& name);
const toml::node* find_node(const toml::table& table, std::string_view name);

}  // namespace turgor

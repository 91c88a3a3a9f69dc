#include "turgor/sim/report/quantity.hpp"

#include <algorithm>

namespace turgor {

namespace {

/// "mesh.volume_ml" -> "mesh", "volume_ml"
std::pair<std::string, std::string_view> first_name(std::string_view key) {
  const std::size_t dot = std::min(key.find('.'), key.size());
  return {std::string(key.substr(0, dot)), key.substr(std::min(dot + 1, key.size()))};
}

}  // namespace

void put(Json& json, const std::string& key, Json value) {
  const auto [name, rest] = first_name(key);
  if (rest.empty())
    json[name] = std::move(value);
  else
    put(json[name], std::string(rest), std::move(value));
}

const Json* find(const Json& json, std::string_view key) {
  const auto [name, rest] = first_name(key);
  if (!json.is_object() || !json.contains(name)) return nullptr;
  return rest.empty() ? &json.at(name) : find(json.at(name), rest);
}

}  // namespace turgor

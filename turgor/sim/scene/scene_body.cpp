#include "turgor/sim/scene/scene_body.hpp"

#include <optional>

namespace turgor {

namespace {

std::vector<std::string> names_of(const Scene& scene, BodyKind kind) {
  std::vector<std::string> names;
  for_each_body(scene, [&](BodyId id, const auto& body) {
    if (id.kind == kind) names.push_back(body.name);
  });
  return names;
}

/// "a", "b" or "c"
std::string one_of(const std::vector<std::string>& words) {
  if (words.size() < 2) return words.empty() ? "" : words[0];
  return fmt::format("{} or {}", fmt::join(words.begin(), words.end() - 1, ", "), words.back());
}

}  // namespace

BodyId read_body(SceneTable& table, std::string_view key, const Scene& scene,
                 std::initializer_list<BodyKind> kinds) {
  std::string name;
  std::vector<std::string> models;
  table.read(key, name, "the name of a body");
  std::vector<std::string> known;
  for (const BodyKind kind : kinds) {
    const std::vector<std::string> names = names_of(scene, kind);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return {kind, int(found - names.begin())};
    known.insert(known.end(), names.begin(), names.end());
    models.push_back(fmt::format("\"{}\"", model_name(kind)));
  }
  if (const toml::node* node = table.find(key); node && node->is_string())
    table.fail(key, fmt::format("the scene has no body {} with model = {}{}", name, one_of(models),
                                suggestion(name, known)));
  return {};
}

void read_stiffness_scale(SceneTable& body, double& scale) {
  body.read(
      "stiffness_scale", scale, within(0.01, 100),
      "factor of all stiffnesses of the body, inclusions too; a slider of the window changes it at once");
}

}  // namespace turgor

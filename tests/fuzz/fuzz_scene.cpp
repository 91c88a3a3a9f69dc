// Any bytes as a scene, and its first line as an override: an error or a scene whose numbers are within their
// ranges, never a crash.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "turgor/sim/scene/scene.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace turgor;
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  std::vector<std::string> overrides;
  if (text.starts_with("#set ")) overrides.push_back(text.substr(5, text.find('\n') - 5));
  const Result<Scene> scene = parse_scene(text, "fuzz.toml", overrides);
  if (!scene) {
    if (scene.error().message.empty()) std::abort();
    return 0;
  }
  const std::size_t touched = scene->organs.size() + scene->rhombi.size();
  if (scene->lattices.empty() && touched == 0 && scene->clothes.empty()) std::abort();
  if (!(scene->duration > 0) || frame_count(*scene) < 1) std::abort();
  for (const LatticeScene& body : scene->lattices) {
    const lattice::SkinParams& skin = body.params.skin;
    if (skin.tension_along >= skin.stiffness || skin.tension_across >= skin.stiffness) std::abort();
    if (body.params.block.x < 1 || body.params.block.x > 64) std::abort();
  }
  for (const IncisionScene& incision : scene->incisions)
    if (incision.body < 0 || std::size_t(incision.body) >= scene->lattices.size()) std::abort();
  for (const SfemScene& organ : scene->organs)
    if (!(organ.material.young > 0) || !(organ.material.poisson < 0.5) || organ.patch.refinement < 1)
      std::abort();
  for (const ToolScene& tool : scene->tools)
    if (tool.body < 0 || std::size_t(tool.body) >= touched + scene->lattices.size()) std::abort();
  const std::size_t counts[] = {scene->lattices.size(), scene->organs.size(), scene->rhombi.size()};
  for (const ClothScene& cloth : scene->clothes)
    for (const ObstacleScene& obstacle : cloth.obstacles)
      if (const auto* body = std::get_if<BodyName>(&obstacle.shape))
        if (body->index < 0 || std::size_t(body->index) >= counts[std::size_t(body->kind)]) std::abort();
  return 0;
}

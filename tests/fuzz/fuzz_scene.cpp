// Any bytes as a scene, and its first line as an override: an error or a scene whose numbers are within their
// ranges, never a crash.
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <string>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_sfem.hpp"

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
  std::vector<std::size_t> counts;  // by BodyKind
  for_each_kind(*scene, *scene,
                [&](BodyKind, const auto& bodies, const auto&) { counts.push_back(bodies.size()); });
  if (std::accumulate(counts.begin(), counts.end(), std::size_t(0)) == 0) std::abort();
  const auto is_allocated = [&](BodyId id) {
    return id.kind != BodyKind::kCloth && id.index >= 0 &&
           std::size_t(id.index) < counts[std::size_t(id.kind)];
  };
  if (!(scene->duration > 0) || frame_count(*scene) < 1) std::abort();
  for (const LatticeScene& body : scene->lattice_bodies) {
    const lattice::SkinParams& skin = body.params.skin;
    if (skin.tension_along >= skin.stiffness || skin.tension_across >= skin.stiffness) std::abort();
    if (body.params.block.x < 1 || body.params.block.x > 64) std::abort();
  }
  for (const IncisionScene& incision : scene->incisions)
    if (incision.body < 0 || std::size_t(incision.body) >= scene->lattice_bodies.size()) std::abort();
  for (const SfemScene& body : scene->sfem_bodies)
    if (!(body.material.young > 0) || !(body.material.poisson < 0.5) || body.patch.refinement < kByElements)
      std::abort();
  for (const ToolScene& tool : scene->tools)
    if (!is_allocated(tool.body)) std::abort();
  for (const ClothScene& cloth : scene->cloth_bodies)
    for (const ObstacleScene& obstacle : cloth.obstacles)
      if (const auto* body = std::get_if<BodyId>(&obstacle.shape))
        if (!is_allocated(*body)) std::abort();
  return 0;
}

#include "turgor/sim/report/report_texture.hpp"

#include <algorithm>
#include <type_traits>

#include <fmt/format.h>

#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using namespace units;
using contact::TextureState;

struct TextureInput {
  const TextureScene& scene;
  const contact::Texture& texture;
  const std::vector<TextureState>& tools;  // empty: no tool has ticks
};

constexpr Unit kHertz{"Hz", "Hz"}, kMicrometers{"um", "µm", 1e6};

/// Largest value of all tools.
Json largest_of_tools(const TextureInput& t, double TextureState::*value) {
  double most = 0;
  for (const TextureState& tool : t.tools) most = std::max(most, tool.*value);
  return t.tools.empty() ? absent() : Json(most);
}

const Quantity<TextureInput> kTexture[] = {
    {"roughness", kMicrometers, "height of the waves",
     [](const TextureInput& t) { return t.texture.map ? absent() : Json(t.texture.waves.roughness); }},
    {"wavelength", kMillimeters, "length of the waves",
     [](const TextureInput& t) { return t.texture.map ? absent() : Json(t.texture.waves.wavelength); }},
    {"height_map", kNone, "file of heights",
     [](const TextureInput& t) { return t.texture.map ? Json(t.scene.height_map.file.string()) : absent(); }},
    {"height_range", kMicrometers, "highest minus lowest height",
     [](const TextureInput& t) { return t.texture.map ? Json(t.texture.map->range) : absent(); }},
    {"force_max", kNewtons, "vibration by texture, largest",
     [](const TextureInput& t) { return largest_of_tools(t, &TextureState::largest_force); }, kEverywhere},
    {"frequency_max", kHertz, "… largest frequency",
     [](const TextureInput& t) { return largest_of_tools(t, &TextureState::largest_rate); }},
    {"limited_ticks", kCount, "… ticks in which it was limited",
     [](const TextureInput& t) -> Json {
       long ticks = 0;
       for (const TextureState& tool : t.tools) ticks += tool.limited_ticks;
       return t.tools.empty() ? absent() : Json(ticks);
     }},
};

Json report_of(const TextureScene& scene, const contact::Texture& texture,
               const std::vector<TextureState>& tools) {
  return is_rough(texture) ? values_of(kTexture, TextureInput{scene, texture, tools}) : Json();
}

/// Bodies of a report that have a texture, with their names.
Json textures_of(const Json& report) {
  Json textures = Json::array();
  for (const Json& body : report.value("bodies", Json::array())) {
    if (!body.contains("texture")) continue;
    Json texture = body["texture"];
    texture["name"] = body.value("name", "");
    textures.push_back(std::move(texture));
  }
  return textures;
}

/// True if frames alone compute the forces on a rough body, and no haptic thread has run.
bool lacks_ticks(const FrameTouchedBody& body) {
  return is_rough(body.texture) && !body.tool_indices.empty() && body.textures.empty();
}

}  // namespace

Json texture_report(const TextureScene& scene, const SfemBody& body) {
  return report_of(scene, body.texture, body.now.textures);
}
Json texture_report(const TextureScene& scene, const RhombusBody& body) {
  return report_of(scene, body.texture, body.now.textures);
}
Json texture_report(const TextureScene& scene, const FrameTouchedBody& body) {
  return report_of(scene, body.texture, body.textures);
}

std::vector<std::string> texture_warnings(const World& world) {
  std::vector<std::string> warnings;
  for_each_touched(world, [&](BodyId, const auto& body) {
    if constexpr (std::is_base_of_v<FrameTouchedBody, std::remove_cvref_t<decltype(body)>>)
      if (lacks_ticks(body))
        warnings.push_back(
            fmt::format("{}: its texture caused no vibration: without a haptic device, forces of this model "
                        "have the rate of frames; add --real-time",
                        body.name));
  });
  return warnings;
}

Section texture_section() {
  return {"Textures of touched surfaces", "body", textures_of, captions_of(kTexture)};
}

}  // namespace turgor

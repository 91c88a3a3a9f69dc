#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

namespace {

std::vector<std::string> preset_names(PresetKind kind) {
  std::vector<std::string> names;
  for (const TissuePreset& preset : tissue_presets())
    if (find_preset(preset.name, kind) == &preset) names.push_back(preset.name);
  return names;
}

}  // namespace

const TissuePreset* read_preset(SceneTable& table, const char* key, PresetKind kind, Meaning meaning) {
  table.describe(key, "", meaning.fallback ? meaning.fallback : "none", meaning.text);
  return preset_of(table, key, kind);
}

const TissuePreset* preset_of(SceneTable& table, const char* key, PresetKind kind) {
  const toml::node* node = table.find(key);
  if (!node) return nullptr;
  const char* family = kind == PresetKind::kSkin ? "skin" : kind == PresetKind::kFabric ? "fabric" : "tissue";
  if (!node->is_string())
    return table.fail_value(key, *node, fmt::format("the name of a {} of `turgor tissues`", family)), nullptr;
  const std::string name = node->as_string()->get();
  if (const TissuePreset* preset = find_preset(name, kind)) return preset;

  // a near name, or the command that lists all
  const std::string nearest = nearest_name(name, preset_names(kind));
  table.fail_value(key, *node,
                   fmt::format("the name of a {} of `turgor tissues`{}", family,
                               nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest)));
  return nullptr;
}

TissueRow tissue_row(std::string component, std::string law, const TissuePreset* preset,
                     std::initializer_list<LawValue> values, const char* defaults) {
  TissueRow row{std::move(component), std::move(law), "", ""};
  bool has_preset = false, has_default = false;
  for (const LawValue& value : values) {
    // the scene wins over the preset, the preset over a default
    const PresetValue* of_preset = preset ? find_value(*preset, value.key) : nullptr;
    const char* from = value.is_given ? "scene" : of_preset ? "preset" : "default";
    has_preset |= !value.is_given && of_preset, has_default |= !value.is_given && !of_preset;
    // the scatter of a preset stands beside its value
    PresetValue shown{value.key, value.value, value.unit};
    if (!value.is_given && of_preset) shown.low = of_preset->low, shown.high = of_preset->high;
    row.values +=
        fmt::format("{}{} {}, {}", row.values.empty() ? "" : "; ", value.key, value_text(shown), from);
  }
  if (has_preset)
    row.source = fmt::format("{}: {} ({}; {})", preset->name, preset->source, preset->species, preset->test);
  if (has_default) row.source += (row.source.empty() ? "" : "; ") + std::string(defaults);
  if (row.source.empty()) row.source = "the scene";
  return row;
}

}  // namespace turgor

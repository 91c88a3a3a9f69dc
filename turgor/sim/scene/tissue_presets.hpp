// Presets of tissues, skin and fabrics: measured values by name, with test, species and source. A scene names
// one (`tissue = "liver"`), and the preset sets the keys that the scene leaves out. `turgor tissues` lists
// them. No value is an estimate of this project, except fits, whose `test` says so.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace turgor {

/// Scope of a preset: `tissue` of solids, `tissue` of rhombus chains only, `skin` of lattices, `fabric`.
enum class PresetKind : std::uint8_t { kSolid, kChain, kSkin, kFabric };

/// A measured value under the name of its scene key.
struct PresetValue {
  std::string key;
  double value = 0;
  std::string unit;
  double low = 0, high = 0;  // stated scatter: quartiles, or one standard deviation; equal = none stated
};

struct TissuePreset {
  std::string name;
  PresetKind kind = PresetKind::kSolid;
  std::string law;
  std::vector<PresetValue> values;
  std::string test, species, source;
};

/// All presets: solids, chains, skin, fabrics.
std::span<const TissuePreset> tissue_presets();
/// Preset of a name that a scene of this kind may use; null if unknown.
const TissuePreset* find_preset(std::string_view name, PresetKind kind);
/// Value of a key; null if the preset does not have it.
const PresetValue* find_value(const TissuePreset& preset, std::string_view key);
/// Value of a key, or `fallback`.
double value_or(const TissuePreset* preset, std::string_view key, double fallback);
/// "tissue", "chain", "skin" or "fabric".
const char* kind_name(PresetKind kind);
/// "5.4 kPa"; with the scatter "51.7 kPa (39.9 to 64.3)".
std::string value_text(const PresetValue& value);

}  // namespace turgor

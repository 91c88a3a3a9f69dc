// Reads the names of presets in scenes, and states the values of a law with their source.
#pragma once

#include <initializer_list>

#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"
#include "turgor/sim/scene/tissue_row.hpp"

namespace turgor {

/// Source of the default skin tension, with the scatter of measured ones.
constexpr const char* kSkinDefaults =
    "defaults of the program; measured tension of living skin is 6 to 138 N/m (Flynn, Taberner, Nielsen "
    "2011: "
    "Biomechanics and Modeling in Mechanobiology 10, 27; Annals of Biomedical Engineering 39, 1935)";
/// Source of the default values of the exponential law of skin.
constexpr const char* kExponentialSkinDefaults =
    "defaults of the program, near a fit to one porcine specimen as skin 1.5 mm thick, preset skin-porcine "
    "(Tac, "
    "Sahli Costabal, Tepole 2022); the tension is not of it";
constexpr const char* kPlainDefaults = "defaults of the program, not measured values";

/// Preset that the text under `key` names. Null if the key is missing, or its value is no such name, which
/// adds a problem with a suggestion.
const TissuePreset* preset_of(SceneTable& table, const char* key, PresetKind kind);
/// The same, and describes the key.
const TissuePreset* read_preset(SceneTable& table, const char* key, PresetKind kind, Meaning meaning);

/// A value of a law. Its source is the scene if the key is given, else the preset, else a default.
struct LawValue {
  const char* key;  // "young"
  double value;
  const char* unit;
  bool is_given;
};

/// Row of a component. `defaults` is the source of values that neither the scene nor the preset sets.
TissueRow tissue_row(std::string component, std::string law, const TissuePreset* preset,
                     std::initializer_list<LawValue> values, const char* defaults = kPlainDefaults);

}  // namespace turgor

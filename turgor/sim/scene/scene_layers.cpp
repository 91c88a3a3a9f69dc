#include "turgor/sim/scene/scene_layers.hpp"

#include "turgor/sim/scene/scene_body.hpp"

namespace turgor {

using lattice::SolidEnergy, lattice::TissueLaw, lattice::TissueLayer;

namespace {

/// Reads one layer. `is_last`: its thickness is the rest of the body if it is missing.
TissueLayer read_layer(SceneTable& table, const lattice::TissueParams& params, bool is_last,
                       std::vector<TissueRow>& rows) {
  TissueLayer layer{.poisson = params.poisson, .stiffening = params.stiffening};
  table.read("name", layer.name, {"of the layer, for the report", "required"});
  table.read("thickness", layer.thickness, positive("m"),
             {"of the layer; the last one may leave it out and is the rest of the body", "required"});
  const TissuePreset* preset =
      read_preset(table, "tissue", PresetKind::kSolid, "a preset of `turgor tissues` for the layer");
  layer.young = value_or(preset, "young", 0);
  table.read("young", layer.young, modulus(), {"Young's modulus of the layer", "of `tissue`"});
  table.read("poisson", layer.poisson, within(0, 0.49), {"Poisson's ratio of the layer", "that of the body"});
  read_stiffening(table, preset, params.energy, layer.stiffening);
  if (table.is_listed()) return layer;

  // missing keys
  if (layer.name.empty()) table.fail("name", "a layer needs a name, such as \"fat\"");
  if (layer.young <= 0) table.fail("young", "a layer needs young [Pa], or tissue with a preset");
  if (!is_last && !table.has("thickness"))
    table.fail("thickness", "every layer except the last needs a thickness [m]");
  table.finish();
  // row of the report
  const std::string component = fmt::format("layer {}", layer.name);
  rows.push_back(tissue_row(component, law_name(params), preset,
                            {{"young", layer.young, "Pa", table.has("young")},
                             {"poisson", layer.poisson, "1", table.has("poisson")}}));
  if (params.energy != SolidEnergy::kNeoHookean) {
    LawValue stiffening = stiffening_value(table, params);
    stiffening.value = layer.stiffening;
    rows.push_back(tissue_row(component + ", stiffening", law_name(params), preset, {stiffening}));
  }
  if (table.has("thickness"))
    rows.push_back(tissue_row(component + ", thickness", law_name(params), nullptr,
                              {{"thickness", layer.thickness, "m", true}}));
  return layer;
}

}  // namespace

const char* law_name(const lattice::TissueParams& params) {
  if (params.law == TissueLaw::kSprings) return "springs";
  switch (params.energy) {
    case SolidEnergy::kNeoHookean:
      return "solid";
    case SolidEnergy::kExponential:
      return "exponential";
    case SolidEnergy::kOgden:
      return "ogden";
  }
  return "";
}

void read_stiffening(SceneTable& table, const TissuePreset* preset, SolidEnergy energy, double& value) {
  double stiffening = value, alpha = value_or(preset, "alpha", value);
  table.read(
      "stiffening", stiffening, within(0, 1000),
      {"exponential only: b of exp(b (I₁ − 3)), the stress grows faster with it; 0 does not stiffen", "0"});
  table.read("alpha", alpha, within(-100, 100),
             {"ogden only: exponent of the stretches, not 0; 2 does not stiffen, brain is about −20",
              "of the preset"});
  if (energy != SolidEnergy::kExponential && table.has("stiffening"))
    table.fail("stiffening",
               "only law = \"exponential\" has a stiffening: set that law, or remove stiffening");
  if (energy != SolidEnergy::kOgden && table.has("alpha"))
    table.fail("alpha", "only law = \"ogden\" has an exponent alpha: set that law, or remove alpha");
  if (energy == SolidEnergy::kOgden && !table.is_listed() && !(std::abs(alpha) >= 0.01))
    table.fail("alpha",
               "expected an exponent of at least 0.01 or at most −0.01, or a preset with one; found " +
                   fmt::format("{}", alpha));
  value = energy == SolidEnergy::kExponential ? stiffening : energy == SolidEnergy::kOgden ? alpha : 0;
}

LawValue stiffening_value(const SceneTable& table, const lattice::TissueParams& params) {
  const char* key = params.energy == SolidEnergy::kOgden ? "alpha" : "stiffening";
  return {key, params.stiffening, "1", table.has(key)};
}

void read_layers(SceneTable& body, lattice::TissueParams& params, std::vector<TissueRow>& rows) {
  body.describe(
      "layers", "", "none",
      "solid laws only: layers of tissue from the skin inward, `[{ name = \"skin\", thickness = 0.0015, "
      "young = 2e5 }, …]`; they replace the moduli of fat and muscle");
  std::vector<SceneTable> tables = body.tables("layers");
  for (std::size_t n = 0; n < tables.size(); n++) {
    const TissueLayer layer = read_layer(tables[n], params, n + 1 == tables.size(), rows);
    if (!tables[n].is_listed()) params.layers.push_back(layer);
  }
  if (params.layers.empty()) return;
  if (params.law == TissueLaw::kSprings)
    body.fail("layers", "springs have no layers: set tissue.law = \"solid\", or remove layers");
  if (params.partial_cells)
    body.fail("layers", "cells of layers are whole: remove tissue.partial_cells, or layers");
}

}  // namespace turgor

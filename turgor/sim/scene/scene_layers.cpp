#include "turgor/sim/scene/scene_layers.hpp"

#include "turgor/sim/scene/scene_body.hpp"

namespace turgor {

using lattice::SolidEnergy, lattice::TissueLaw, lattice::TissueLayer;

namespace {

/// Reads one layer. `is_last`: its thickness is the rest of the body if it is missing.
TissueLayer read_layer(SceneTable& table, const lattice::TissueParams& params, bool is_last,
                       std::vector<TissueRow>& rows) {
  TissueLayer layer{.poisson = params.poisson, .stiffening = params.stiffening, .fiber = params.fiber};
  table.read("name", layer.name, {"of the layer, for the report", "required"});
  table.read("thickness", layer.thickness, positive("m"),
             {"of the layer; the last one may leave it out and is the rest of the body", "required"});
  const TissuePreset* preset =
      read_preset(table, "tissue", PresetKind::kSolid, "a preset of `turgor tissues` for the layer");
  layer.young = value_or(preset, "young", 0);
  table.read("young", layer.young, modulus(), {"Young's modulus of the layer", "of `tissue`"});
  table.read("poisson", layer.poisson, within(0, 0.49), {"Poisson's ratio of the layer", "that of the body"});
  read_stiffening(table, preset, params.energy, layer.stiffening);
  read_fiber(table, params, layer.fiber);
  table.read(
      "slide", layer.slide, within(0.002, 1),
      "factor of the layer's shear modulus; a thin layer with a small one lets its neighbors slide, and "
      "bears pressure as before");
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
  add_fiber_row(table, component, layer.fiber, rows);
  if (table.has("slide"))
    rows.push_back(
        tissue_row(component + ", sliding", law_name(params), nullptr, {{"slide", layer.slide, "1", true}}));
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

void read_fiber(SceneTable& table, const lattice::TissueParams& params, lattice::FiberParams& fiber) {
  SceneTable keys = table.table("fiber");
  keys.read("stiffness", fiber.stiffness, not_negative("Pa"),
            "exponential only: k1 of fibers in the cells; 0: none");
  keys.read("stiffening", fiber.stiffening, within(0, 1000),
            "exponential only: k2, how fast the fibers stiffen with strain");
  keys.read("direction", fiber.direction, any_number("1"), "exponential only: of the fibers, patient frame");
  if (norm(fiber.direction) == 0) keys.fail("direction", "expected a vector that is not zero");
  if (params.energy != SolidEnergy::kExponential && table.has("fiber"))
    table.fail("fiber", "only law = \"exponential\" has fibers: set that law, or remove fiber");
  keys.finish();
}

void add_fiber_row(SceneTable& table, const std::string& component, const lattice::FiberParams& fiber,
                   std::vector<TissueRow>& rows) {
  if (!(fiber.stiffness > 0)) return;
  const bool given = table.has("fiber");
  rows.push_back(tissue_row(
      component + ", fibers", "exponential", nullptr,
      {{"stiffness", fiber.stiffness, "Pa", given}, {"stiffening", fiber.stiffening, "1", given}}));
}

void read_permanent_set(SceneTable& body, lattice::TissueParams& params, std::vector<TissueRow>& rows) {
  SceneTable table = body.table("permanent_set");
  lattice::PermanentSet& set = params.set;
  table.read(
      "share", set.share, within(0, 0.95),
      "solid laws only: share of the stress beyond `strain` that relaxes for good, so that a dent stays; "
      "0: none");
  table.read("strain", set.strain, within(0, 10),
             "equivalent strain from which on the tissue sets; in tension, about the elongation");
  table.read("time", set.time, inside(0, 1000, "s"), "of that relaxation");
  table.finish();
  if (set.share == 0) return;
  if (params.law != TissueLaw::kSolid)
    body.fail("permanent_set", "springs do not set: set tissue.law = \"solid\", or remove permanent_set");
  if (params.partial_cells)
    body.fail("permanent_set", "cells that set are whole: remove tissue.partial_cells, or permanent_set");
  rows.push_back(tissue_row("permanent set", law_name(params), nullptr,
                            {{"strain", set.strain, "1", table.has("strain")},
                             {"share", set.share, "1", table.has("share")},
                             {"time", set.time, "s", table.has("time")}}));
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

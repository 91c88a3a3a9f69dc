#include "turgor/sim/scene/scene_layers.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_needle_layers.hpp"
#include "turgor/sim/scene/scene_prony.hpp"

namespace turgor {

using lattice::SolidEnergy, lattice::TissueLaw, lattice::TissueLayer;

namespace {

/// Adds the rows of a layer to the report.
void add_layer_rows(SceneTable& table, const TissueLayer& layer, const lattice::TissueParams& params,
                    const TissuePreset* preset, std::vector<TissueRow>& rows) {
  const std::string component = fmt::format("layer {}", layer.name);
  const SolidEnergy energy = energy_of(layer, params);
  const auto add = [&](const char* what, const TissuePreset* of, std::initializer_list<LawValue> values) {
    rows.push_back(tissue_row(component + what, law_name(energy), of, values));
  };
  add("", preset,
      {{"young", layer.young, "Pa", table.has("young")},
       {"poisson", layer.poisson, "1", table.has("poisson")}});
  if (energy != SolidEnergy::kNeoHookean)
    add(", stiffening", preset, {stiffening_value(table, energy, layer.stiffening)});
  add_fiber_row(table, component, layer.fiber, rows);
  if (table.has("slide")) add(", sliding", nullptr, {{"slide", layer.slide, "1", true}});
  if (table.has("thickness")) add(", thickness", nullptr, {{"thickness", layer.thickness, "m", true}});
  if (layer.label > 0) add(", region", nullptr, {{"label", double(layer.label), "1", true}});
  if (layer.hu)
    add(", region", nullptr, {{"from", (*layer.hu)[0], "HU", true}, {"to", (*layer.hu)[1], "HU", true}});
}

/// Reads where a layer lies. `is_last`: its thickness is the rest of the body if it is missing.
void read_position(SceneTable& table, bool is_last, bool has_labels, SceneLabels& labels,
                   TissueLayer& layer) {
  table.read("thickness", layer.thickness, positive("m"),
             {"of the layer; the last one may leave it out and is the rest of the body", "required"});
  read_label(table, "label", labels, layer.label,
             {"instead of `thickness`: the layer is the tissue with this label, a number or a name", "none"});
  read_hu_range(table, layer.hu);
  if (table.is_listed()) return;
  if (table.has("label") && !has_labels)
    table.fail("label", "a layer by label needs a segmentation: add labels = \"seg.nii.gz\" to the body");
  if (table.has("label") + table.has("hu") + table.has("thickness") > 1)
    table.fail(table.has("thickness") ? "thickness" : "hu",
               "a layer has one of thickness, label and hu: the others would be ignored");
  if (!is_last && !table.has("thickness") && !table.has("label") && !table.has("hu"))
    table.fail("thickness",
               "every layer except the last needs a thickness [m], or is a region by label or hu");
}

/// Reads the law of a layer. A law other than that of the body has none of its stiffening and fibers.
void read_layer_law(SceneTable& table, const lattice::TissueParams& params, TissueLayer& layer) {
  SolidEnergy energy = params.energy;
  table.read_choice<SolidEnergy>("law", energy,
                                 {{law_name(SolidEnergy::kNeoHookean), SolidEnergy::kNeoHookean},
                                  {law_name(SolidEnergy::kExponential), SolidEnergy::kExponential},
                                  {law_name(SolidEnergy::kOgden), SolidEnergy::kOgden}},
                                 {"of the layer, as `tissue.law`; layers of different laws may lie beside "
                                  "each other",
                                  "that of the body"});
  if (energy == params.energy) return;
  layer.energy = energy;
  layer.stiffening = 0, layer.fiber = {};
}

/// Reads the color of a layer, if it has one.
std::optional<Rgb> read_layer_color(SceneTable& table) {
  Int3 color;
  table.read("color", color, within(0, 255),
             {"red, green and blue of the layer on the walls of wounds, as in `[240, 214, 120]` for fat; "
              "layers without it have the color of walls",
              "none"});
  if (!table.has("color")) return std::nullopt;
  return Rgb{std::uint8_t(color.x), std::uint8_t(color.y), std::uint8_t(color.z)};
}

/// Reads one layer, with its toughness.
TissueLayer read_layer(SceneTable& table, const lattice::TissueParams& params, bool is_last, bool has_labels,
                       SceneLabels& labels, double& toughness, std::vector<TissueRow>& rows) {
  TissueLayer layer{.poisson = params.poisson, .stiffening = params.stiffening, .fiber = params.fiber};
  table.read("name", layer.name, {"of the layer, for the report", "required"});
  read_position(table, is_last, has_labels, labels, layer);
  // law
  read_layer_law(table, params, layer);
  const SolidEnergy energy = energy_of(layer, params);
  const TissuePreset* preset =
      read_preset(table, "tissue", PresetKind::kSolid, "a preset of `turgor tissues` for the layer");
  layer.young = value_or(preset, "young", 0);
  table.read("young", layer.young, modulus(), {"Young's modulus of the layer", "of `tissue`"});
  table.read("poisson", layer.poisson, within(0, 0.499),
             {"Poisson's ratio of the layer", "that of the body"});
  read_stiffening(table, preset, energy, layer.stiffening);
  read_fiber(table, energy, layer.fiber);
  table.read(
      "slide", layer.slide, within(0.002, 1),
      "factor of the layer's shear modulus; a thin layer with a small one lets its neighbors slide, and "
      "bears pressure as before");
  table.read("toughness", toughness, within(-1, 1e5, "J/m²"),
             {"of the layer against needles, as `inside.NAME.toughness`; -1 is the default",
              "that of the needle's `shape.toughness`"});
  // relaxation
  check_pairs_of_preset(table, preset);
  std::vector<TissueRow> pairs;
  Prony prony = table.has("viscosity") ? prony_of(preset, {}) : Prony{};
  read_viscosity(table.table("viscosity"), preset, prony, pairs,
                 fmt::format("layer {}, viscosity", layer.name));
  if (table.has("viscosity")) layer.prony = prony;
  if (table.is_listed()) return layer;

  // missing keys
  if (layer.name.empty()) table.fail("name", "a layer needs a name, such as \"fat\"");
  if (layer.young <= 0) table.fail("young", "a layer needs young [Pa], or tissue with a preset");
  table.finish();
  add_layer_rows(table, layer, params, preset, rows);
  rows.insert(rows.end(), pairs.begin(), pairs.end());
  if (toughness >= 0)
    rows.push_back(tissue_row(fmt::format("layer {}, toughness", layer.name), "needles", nullptr,
                              {{"toughness", toughness, "J/m²", true}}));
  return layer;
}

/// Resistance of layers to needles: regions with a toughness, and all layers by depth if one of them has one.
std::vector<NeedleLayerScene> tough_layers(const std::vector<TissueLayer>& layers,
                                           const std::vector<double>& toughness) {
  TURGOR_ASSERT(layers.size() == toughness.size(), "every layer has a toughness");
  constexpr double kRestOfBody = 100;  // [m]
  bool has_depth = false;
  for (std::size_t n = 0; n < layers.size(); n++) has_depth |= toughness[n] >= 0 && !is_region(layers[n]);
  std::vector<NeedleLayerScene> tough;
  double depth = 0;
  for (std::size_t n = 0; n < layers.size(); n++) {
    const TissueLayer& layer = layers[n];
    NeedleLayerScene one{.name = layer.name, .label = layer.label, .hu = layer.hu, .toughness = toughness[n]};
    if (!is_region(layer)) {
      depth = layer.thickness > 0 ? depth + layer.thickness : kRestOfBody;
      one.depth = depth, one.is_of_layers = true;
    }
    if (one.is_of_layers ? has_depth : toughness[n] >= 0) tough.push_back(std::move(one));
  }
  return tough;
}

/// Refuses a region whose tissue another layer, or tissue.labels, has as well.
void check_region(SceneTable& table, const TissueLayer& layer, const lattice::TissueParams& params) {
  if (layer.label > 0 && params.young_of_label.contains(layer.label))
    table.fail("label", "tissue.labels has a modulus for this label: set it in the layer only");
  for (const TissueLayer& other : params.layers) {
    if (layer.label > 0 && layer.label == other.label)
      table.fail("label",
                 fmt::format("layer {} has the same label: expected each label in one layer", other.name));
    if (overlap(layer.hu, other.hu))
      table.fail("hu",
                 fmt::format("the range overlaps that of {}: expected each HU in one layer", other.name));
  }
}

}  // namespace

const char* law_name(const lattice::TissueParams& params) {
  return params.law == TissueLaw::kSprings ? "springs" : law_name(params.energy);
}

const char* law_name(SolidEnergy energy) {
  switch (energy) {
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
  double stiffening = value_or(preset, "stiffening", value), alpha = value_or(preset, "alpha", value);
  table.read("stiffening", stiffening, within(0, 1000),
             "exponential only: b of exp(b (I₁ − 3)), the stress grows faster with it; 0 does not stiffen. A "
             "preset may have one");
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

LawValue stiffening_value(const SceneTable& table, SolidEnergy energy, double value) {
  const char* key = energy == SolidEnergy::kOgden ? "alpha" : "stiffening";
  return {key, value, "1", table.has(key)};
}

void read_fiber(SceneTable& table, SolidEnergy energy, lattice::FiberParams& fiber,
                std::filesystem::path* field) {
  SceneTable keys = table.table("fiber");
  keys.read("stiffness", fiber.stiffness, not_negative("Pa"),
            "exponential only: k1 of fibers in the cells; 0: none");
  keys.read("stiffening", fiber.stiffening, within(0, 1000),
            "exponential only: k2, how fast the fibers stiffen with strain");
  keys.read(
      "direction", fiber.direction, any_number("1"),
      "exponential only: of the fibers, patient frame; in a layer by label, `[0, 0, 0]` is the long axis "
      "of the label");
  if (field)
    keys.read_path("direction_field", *field,
                   "exponential only: a three-component image in the patient frame; its direction replaces "
                   "`direction`, also those of layers, wherever it is not zero");
  if (norm(fiber.direction) == 0 && !table.has("label"))
    keys.fail("direction",
              "expected a vector that is not zero, or a layer with a label, which has a long axis");
  if (energy != SolidEnergy::kExponential && table.has("fiber"))
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

void read_layers(SceneTable& body, bool has_labels, SceneLabels& labels, lattice::TissueParams& params,
                 LayerExtras& extras, std::vector<TissueRow>& rows) {
  body.describe(
      "layers", "", "none",
      "solid laws only: layers of tissue from the skin inward, `[{ name = \"skin\", thickness = 0.0015, "
      "young = 2e5 }, …]`, which replace the moduli of fat and muscle; and regions by `label` or `hu`, which "
      "replace all else");
  constexpr std::size_t kMostLayers = 200;  // a cell stores its layer in a byte
  std::vector<SceneTable> tables = body.tables("layers");
  if (tables.size() > kMostLayers)
    return body.fail("layers",
                     fmt::format("expected at most {} layers, found {}", kMostLayers, tables.size()));
  std::size_t last = tables.size();  // of those by depth
  for (std::size_t n = 0; n < tables.size(); n++)
    if (!tables[n].has("label") && !tables[n].has("hu")) last = n;
  std::vector<double> toughness;
  for (std::size_t n = 0; n < tables.size(); n++) {
    double own = kNeedlesOwn;
    const std::optional<Rgb> color = read_layer_color(tables[n]);
    const TissueLayer layer = read_layer(tables[n], params, n == last, has_labels, labels, own, rows);
    if (tables[n].is_listed()) continue;
    check_region(tables[n], layer, params);
    params.layers.push_back(layer);
    toughness.push_back(own), extras.colors.push_back(color);
  }
  extras.tough = tough_layers(params.layers, toughness);
  if (params.layers.empty()) return;
  if (params.law == TissueLaw::kSprings)
    body.fail("layers", "springs have no layers: set tissue.law = \"solid\", or remove layers");
  if (params.partial_cells)
    body.fail("layers", "cells of layers are whole: remove tissue.partial_cells, or layers");
}

}  // namespace turgor

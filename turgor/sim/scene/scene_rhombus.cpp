#include "turgor/sim/scene/scene_rhombus.hpp"

#include <numbers>

#include "turgor/models/rhombus/tissues.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_ct.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_prony.hpp"
#include "turgor/sim/scene/scene_texture.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kUnitStiffness = within(1e-6, 1e6, "N/m");  // calibrate finds no other
const Allowed kFactor = within(1e-6, 1e6);                // of the stiffness

RhombusSource read_source(SceneTable& body, const Scene& scene) {
  // exactly one source is allowed
  const std::vector<std::string> kinds = {"surface", "surface_of"};
  body.describe("surface_of", "", "none", "or the name of a body with `model = \"sfem\"` in the same scene");
  body.require(kinds, "the body's surface: a file, { phantom = \"liver\" }, or that of another body");
  if (body.has("surface") && body.has("surface_of"))
    body.fail("surface_of", "a body has one surface: either surface or surface_of");
  // surface of another body
  if (body.has("surface_of"))
    return SurfaceOfBody{read_body(body, "surface_of", scene, {BodyKind::kSfem}).index};
  // phantom
  const toml::node* node = body.find("surface");
  if (node && node->is_table()) {
    SceneTable table = body.table("surface");
    std::string phantom;
    PhantomLiverSurface liver;
    table.begin_group("rhombus surface");
    table.require({"phantom"}, "\"liver\"");
    table.read_choice("phantom", phantom, {"liver"}, {"`\"liver\"`: 3116 vertices", "required"});
    table.read("detail", liver.detail, within(0.2, 20), "divides the edge length of the phantom");
    table.finish();
    return liver;
  }
  // surface file
  SurfaceFile surface;
  body.read_path("surface", surface.file,
                 {"a closed surface (OBJ, STL, PLY, VTP, VTK), or `{ phantom = \"liver\" }`",
                  "required, or `surface_of`"});
  body.read("scale", surface.scale, inside(0, 1e6, "m"), "meters per unit of the file of `surface`");
  surface.is_scale_given = body.has("scale");
  read_up(body, "up", surface.up);
  return surface;
}

/// Chain of the tissue's preset, and its viscosity. Returns the preset.
const TissuePreset& read_tissue(SceneTable& body, RhombusScene& scene) {
  const TissuePreset* named = read_preset(
      body, "tissue", PresetKind::kChain,
      {"source of the chain's parameters, a preset of `turgor tissues`: `\"liver\"` (human, as measured), "
       "`\"liver-porcine\"`, `\"breast-fat\"`, …, or `\"zhang-2010\"`, the paper's liver",
       "`\"liver\"`"});
  const TissuePreset& preset = named ? *named : *find_preset(rhombus::tissues()[0].name, PresetKind::kChain);
  scene.tissue = preset.name;

  // chains as printed, or fitted to the modulus
  const rhombus::Tissue* printed = rhombus::find_tissue(preset.name);
  scene.params.chain = printed ? printed->chain : rhombus::chain_of_modulus(value_or(&preset, "young", 0));
  scene.params.viscosity = prony_of(&preset, scene.params.viscosity);
  return preset;
}

/// Rows of the report: the modulus or the printed chain, and the chain as it is used.
void add_rows(SceneTable& body, const TissuePreset& preset, RhombusScene& scene) {
  const rhombus::ChainParams& chain = scene.params.chain;
  SceneTable given = body.table("chain");
  if (preset.kind == PresetKind::kSolid)
    scene.tissues.push_back(
        tissue_row("tissue", "linear", &preset, {{"young", value_or(&preset, "young", 0), "Pa", false}}));
  scene.tissues.push_back(
      tissue_row("chain", "rhombus chain", preset.kind == PresetKind::kChain ? &preset : nullptr,
                 {{"chain.normal", chain.normal, "N/m", given.has("normal")},
                  {"chain.tangential", chain.tangential, "N/m", given.has("tangential")},
                  {"chain.decay", chain.decay, "1", given.has("decay")},
                  {"chain.angle", chain.angle * 180 / std::numbers::pi, "degrees", given.has("angle")},
                  {"chain.side", chain.side, "m", given.has("side")}},
                 "chain fitted to the modulus of the tissue"));
}

/// Chain parameters that replace those of the tissue.
void read_chain(SceneTable table, rhombus::ChainParams& chain) {
  // stiffness of the units
  table.read("normal", chain.normal, kUnitStiffness, {"k_N of every unit", "the tissue's"});
  table.read("tangential", chain.tangential, kUnitStiffness, {"k_T of the first unit", "the tissue's"});
  table.read("decay", chain.decay, positive(""),
             {"β: k_T grows by e^(1/β) from unit to unit", "the tissue's"});
  // rest geometry; the scene gives degrees
  double degrees = chain.angle * 180 / std::numbers::pi;
  table.read("angle", degrees, inside(0, 90, "degrees"), {"θ at rest", "the tissue's"});
  chain.angle = degrees * std::numbers::pi / 180;
  table.read("side", chain.side, inside(0, 1, "m"),
             {"a: a unit is 2a cos θ wide and 2a sin θ high", "the tissue's"});
  // limits and scaling of the response
  table.read("boundary", chain.boundary, inside(0, 0.5),
             "units that turn by less than this fraction of θ do not move");
  table.read(
      "stiffening", chain.stiffening, inside(0, 100),
      {"a unit stretched by its own height is at most e to this power times as stiff", "the tissue's"});
  table.read(
      "tip", chain.tip, within(0, 1, "m"),
      {"radius of the ball for which the chain was measured: it is scaled with the contact radius of other "
       "tools, which grows as a ball goes deeper; 0: no scaling",
       "the tissue's"});
  table.finish();
}

LabelStiffness read_label_stiffness(SceneTable& table) {
  // segmentation file or phantom
  LabelStiffness stiffness;
  const toml::node* labels = table.find("labels");
  if (labels && labels->is_table())
    stiffness.phantom = read_phantom(table.table("labels"));
  else
    table.read_path("labels", stiffness.labels, {"a segmentation, or a phantom as of `ct`", "none"});
  // factor per label
  SceneLabels names = scene_labels(table);
  SceneTable factors = table.table("factors");
  for (const std::string& name : factors.keys()) {
    double factor = 1;
    factors.read(name, factor, kFactor, "stiffness factor of this label");
    stiffness.factors[find_label(factors, name, name, names)] = factor;
  }
  stiffness.label_note = names.note;
  factors.finish();
  return stiffness;
}

CtStiffness read_ct_stiffness(SceneTable& table) {
  const std::string expected = "pairs [HU, factor from 1e-6 to 1e6], ascending, as [[-100, 0.5], [40, 1]]";
  CtStiffness stiffness{read_ct_source(table), {}};
  const toml::node* pairs = table.find("factors");
  if (!pairs) return stiffness;
  if (!pairs->is_array() || pairs->as_array()->empty())
    return table.fail_value("factors", *pairs, expected), stiffness;
  for (const toml::node& pair : *pairs->as_array()) {
    if (!pair.is_array()) return table.fail_value("factors", pair, expected), stiffness;
    const std::vector<double> v = table.numbers("factors", pair, any_number("HU or 1"));
    if (v.empty()) return stiffness;  // a problem was added
    const bool ascends = stiffness.factors.empty() || v[0] > stiffness.factors.rbegin()->first;
    if (v.size() != 2 || !ascends || v[1] < kFactor.low || v[1] > kFactor.high)
      return table.fail_value("factors", pair, expected), stiffness;
    stiffness.factors[v[0]] = v[1];
  }
  return stiffness;
}

/// Stiffness from the sfem body of `surface_of`; another body is an error.
ElasticStiffness read_elastic_stiffness(SceneTable& table, const Scene& scene, const RhombusSource& source) {
  const ElasticStiffness stiffness{read_body(table, "body", scene, {BodyKind::kSfem}).index};
  const auto* surface = std::get_if<SurfaceOfBody>(&source);
  if (!surface || surface->body != stiffness.body)
    table.fail("body", "expected the body that surface_of names");
  return stiffness;
}

StiffnessScene read_stiffness(SceneTable table, const Scene& scene, const RhombusSource& source) {
  // stiffness from the body of surface_of
  StiffnessScene stiffness;
  if (table.has("body")) {
    stiffness.source = read_elastic_stiffness(table, scene, source);
    table.finish();
    return stiffness;
  }
  // require and describe the factors
  table.describe("factors", "HU, 1", "required",
                 "stiffness factors by label: `{ nodule = 8 }`; or by CT value, linear between the pairs: "
                 "`[[-100, 0.5], "
                 "[40, 1], [300, 8]]`");
  table.require({"labels", "ct", "body"}, "a segmentation, a CT, a phantom, or the body of surface_of");
  table.require({"factors"},
                "stiffness factors: { nodule = 8 } by label, [[40, 1], [300, 8]] by CT value [HU]");
  // factors from CT values or from labels
  if (table.has("labels") && table.has("ct"))
    table.fail("ct", "stiffness comes from labels or from a CT, not from both");
  if (table.has("ct"))
    stiffness.source = read_ct_stiffness(table);
  else
    stiffness.source = read_label_stiffness(table);
  // sampling depth
  table.read("depth", stiffness.depth, inside(0, 1, "m"),
             "largest depth below the surface at which stiffness is sampled");
  table.finish();
  return stiffness;
}

}  // namespace

RhombusScene read_rhombus_scene(SceneTable body, const std::string& name, const Scene& scene) {
  RhombusScene made;
  // surface, tissue and chain
  body.begin_group("rhombus");
  made.name = name, made.source_location = body.location();
  made.source = read_source(body, scene);
  const TissuePreset& preset = read_tissue(body, made);
  read_chain(body.table("chain"), made.params.chain);
  // response of the tissue
  read_stiffness_scale(body, made.stiffness_scale);
  body.read("bulge", made.params.bulge, within(0, 1),
            "fraction of the indented volume that rises around the contact");
  body.read(
      "tear", made.params.tear, inside(0, 1e4, "N"),
      "the largest force that the tissue bears. At this force grasped tissue slips out of the forceps "
      "until they open again, and the force of a press is clamped. The report warns of it. Chains alone "
      "have no such limit");
  // viscosity
  add_rows(body, preset, made);
  read_viscosity(body.table("viscosity"), &preset, made.params.viscosity, made.tissues);
  read_texture(body, made.texture);
  // optional variation of stiffness
  if (body.has("stiffness")) made.stiffness = read_stiffness(body.table("stiffness"), scene, made.source);
  body.finish();
  return made;
}

}  // namespace turgor

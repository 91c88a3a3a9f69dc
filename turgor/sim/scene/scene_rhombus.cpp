#include "turgor/sim/scene/scene_rhombus.hpp"

#include <numbers>

#include "turgor/models/rhombus/tissues.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_ct.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

RhombusSource read_source(SceneTable& body, const Scene& scene) {
  const std::vector<std::string> kinds = {"surface", "surface_of"};
  body.describe("surface_of", "", "none", "or the name of a body with `model = \"sfem\"` in the same scene");
  body.require(kinds, "the body's surface: a file, { phantom = \"liver\" }, or that of another body");
  if (body.has("surface") && body.has("surface_of"))
    body.fail("surface_of", "a body has one surface: either surface or surface_of");
  if (body.has("surface_of"))
    return SurfaceOfBody{read_body(body, "surface_of", scene, {BodyKind::kSfem}).index};
  const toml::node* node = body.find("surface");
  if (node && node->is_table()) {
    SceneTable table = body.table("surface");
    std::string phantom;
    PhantomLiverSurface liver;
    table.begin_group("rhombus surface");
    table.require({"phantom"}, "\"liver\"");
    table.read_choice("phantom", phantom, {"liver"}, {"`\"liver\"`: 3116 vertices", "required"});
    table.read("detail", liver.detail, within(0.2, 20), "edges of the phantom are shorter by this");
    table.finish();
    return liver;
  }
  SurfaceFile surface;
  body.read_path("surface", surface.file,
                 {"a closed surface (OBJ, STL, PLY, VTP, VTK), or `{ phantom = \"liver\" }`",
                  "required, or `surface_of`"});
  body.read("scale", surface.scale, inside(0, 1e6, "m"), "metres a unit of the file of `surface`");
  read_up(body, "up", surface.up);
  return surface;
}

void read_tissue(SceneTable& body, RhombusScene& scene) {
  std::vector<std::string> names;
  for (const rhombus::Tissue& tissue : rhombus::tissues()) names.push_back(tissue.name);
  scene.tissue = names[0];
  body.read_choice(
      "tissue", scene.tissue, names,
      "where the chain comes from: `\"liver\"` (human, as measured), `\"liver-porcine\"`, "
      "`\"breast-fat\"`, `\"breast-gland\"`, `\"fibroadenoma\"`, or `\"zhang-2010\"`, the paper's liver");
  if (const rhombus::Tissue* tissue = rhombus::find_tissue(scene.tissue)) scene.params.chain = tissue->chain;
}

/// Replaces what the tissue says, key by key.
void read_chain(SceneTable table, rhombus::ChainParams& chain) {
  table.read("normal", chain.normal, positive("N/m"), {"k_N of every unit", "the tissue's"});
  table.read("tangential", chain.tangential, positive("N/m"), {"k_T of the first unit", "the tissue's"});
  table.read("decay", chain.decay, positive(""),
             {"β: k_T grows by e^(1/β) from unit to unit", "the tissue's"});
  double degrees = chain.angle * 180 / std::numbers::pi;
  table.read("angle", degrees, inside(0, 90, "degrees"), {"θ at rest", "the tissue's"});
  chain.angle = degrees * std::numbers::pi / 180;
  table.read("side", chain.side, inside(0, 1, "m"),
             {"a: a unit is 2a cos θ wide and 2a sin θ high", "the tissue's"});
  table.read("boundary", chain.boundary, inside(0, 0.5),
             "units that turn by less than this fraction of θ stay where they are");
  table.read("stiffening", chain.stiffening, inside(0, 100),
             {"pulled by its own height, a unit grows stiffer by e to this at most", "the tissue's"});
  table.read(
      "tip", chain.tip, within(0, 1, "m"),
      {"radius of the ball that the chain is for: under others it is larger or smaller as a whole, and a "
       "ball's touch grows as it goes in; 0: every tool feels the chain itself",
       "the tissue's"});
  table.finish();
}

LabelStiffness read_label_stiffness(SceneTable& table) {
  LabelStiffness stiffness;
  const toml::node* labels = table.find("labels");
  if (labels && labels->is_table())
    stiffness.phantom = read_phantom(table.table("labels"));
  else
    table.read_path("labels", stiffness.labels, {"a segmentation, or a phantom as of `ct`", "none"});
  SceneLabels names = scene_labels(table);
  SceneTable factors = table.table("factors");
  for (const std::string& name : factors.keys()) {
    double factor = 1;
    factors.read(name, factor, positive(""), "how many times as stiff this label is");
    stiffness.factors[find_label(factors, name, name, names)] = factor;
  }
  stiffness.label_note = names.note;
  factors.finish();
  return stiffness;
}

CtStiffness read_ct_stiffness(SceneTable& table) {
  const std::string expected = "pairs [HU, factor above 0], ascending, as [[-100, 0.5], [40, 1]]";
  CtStiffness stiffness{read_ct_source(table), {}};
  const toml::node* pairs = table.find("factors");
  if (!pairs) return stiffness;
  if (!pairs->is_array() || pairs->as_array()->empty())
    return table.fail_value("factors", *pairs, expected), stiffness;
  for (const toml::node& pair : *pairs->as_array()) {
    if (!pair.is_array()) return table.fail_value("factors", pair, expected), stiffness;
    const std::vector<double> v = table.numbers("factors", pair, any_number("HU or 1"));
    if (v.empty()) return stiffness;  // and a note of what was wrong
    const bool ascends = stiffness.factors.empty() || v[0] > stiffness.factors.rbegin()->first;
    if (v.size() != 2 || !ascends || v[1] <= 0) return table.fail_value("factors", pair, expected), stiffness;
    stiffness.factors[v[0]] = v[1];
  }
  return stiffness;
}

/// The body whose surface this is, and no other.
ElasticStiffness read_elastic_stiffness(SceneTable& table, const Scene& scene, const RhombusSource& source) {
  const ElasticStiffness stiffness{read_body(table, "body", scene, {BodyKind::kSfem}).index};
  const auto* surface = std::get_if<SurfaceOfBody>(&source);
  if (!surface || surface->body != stiffness.body)
    table.fail("body", "stiffness is that of the body whose surface_of this is");
  return stiffness;
}

StiffnessScene read_stiffness(SceneTable table, const Scene& scene, const RhombusSource& source) {
  StiffnessScene stiffness;
  if (table.has("body")) {
    stiffness.source = read_elastic_stiffness(table, scene, source);
    table.finish();
    return stiffness;
  }
  table.describe(
      "factors", "HU, 1", "required",
      "how many times as stiff what a label marks is: `{ nodule = 8 }`; or what has a grey value, linear "
      "between the pairs: `[[-100, 0.5], [40, 1], [300, 8]]`");
  table.require({"labels", "ct", "body"}, "a segmentation, a CT, a phantom, or the body of surface_of");
  table.require({"factors"},
                "how many times as stiff: { nodule = 8 } of labels, [[40, 1], [300, 8]] of a CT's HU");
  if (table.has("labels") && table.has("ct"))
    table.fail("ct", "stiffness is of labels or of a CT, not of both");
  if (table.has("ct"))
    stiffness.source = read_ct_stiffness(table);
  else
    stiffness.source = read_label_stiffness(table);
  table.read("depth", stiffness.depth, inside(0, 1, "m"), "below the surface, felt from there");
  table.finish();
  return stiffness;
}

}  // namespace

RhombusScene read_rhombus_scene(SceneTable body, const std::string& name, const Scene& scene) {
  RhombusScene made;
  body.begin_group("rhombus");
  made.name = name, made.place = body.place();
  made.source = read_source(body, scene);
  read_tissue(body, made);
  read_chain(body.table("chain"), made.params.chain);
  body.read("bulge", made.params.bulge, within(0, 1),
            "of the volume that is pressed in, so much rises around it");
  body.read("tear", made.params.tear, inside(0, 1e4, "N"),
            "the largest force that tissue bears: what forceps hold slips out of them there, and stays out "
            "until they open; a press gives way and feels no more than this. Reported and warned of. Chains "
            "alone have no such end");
  SceneTable viscosity = body.table("viscosity");
  viscosity.read("ratio", made.params.viscosity.stiffening, within(0, 100),
                 "a sudden press is 1 + ratio times as stiff");
  viscosity.read("time", made.params.viscosity.time, inside(0, 1000, "s"), "in which that relaxes");
  viscosity.finish();
  if (body.has("stiffness")) made.stiffness = read_stiffness(body.table("stiffness"), scene, made.source);
  body.finish();
  return made;
}

}  // namespace turgor

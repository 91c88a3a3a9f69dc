#include "turgor/sim/scene/scene_lattice.hpp"

#include <cmath>

#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_cells.hpp"
#include "turgor/sim/scene/scene_ct.hpp"
#include "turgor/sim/scene/scene_held.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_layers.hpp"
#include "turgor/sim/scene/scene_needle_layers.hpp"
#include "turgor/sim/scene/scene_prony.hpp"
#include "turgor/sim/scene/scene_skin.hpp"
#include "turgor/sim/scene/scene_texture.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"

namespace turgor {

namespace {

using lattice::Method, lattice::Ordering;
using lattice::SkinLaw;
using lattice::SolidEnergy;
using lattice::TissueLaw;

/// True if the body has labels: a file of them, or a phantom's.
bool has_labels(SceneTable& body) {
  const toml::node* ct = body.find("ct");
  return body.has("labels") || (ct && ct->is_table());
}

void read_only(SceneTable& body, SceneLabels& labels, LatticeScene& scene) {
  read_label(
      body, "only", labels, scene.only,
      {"one label of `labels`, or of the phantom, is the body: a number, or a name such as `\"liver\"`. Its "
       "largest component stays, with all that it encloses; everything else becomes air, and the CT is "
       "cropped to "
       "it",
       "all"});
  if (scene.only > 0 && !has_labels(body))
    body.fail("only", "a body of one label needs a segmentation: add labels = \"seg.nii.gz\" to the body");
}

void read_block(SceneTable& body, Int3& block, double& spacing) {
  body.read("spacing", spacing, within(1e-4, 0.1, "m"),
            {"instead of `block`: the target spacing of lattice nodes, rounded to whole voxels, so that one "
             "scene fits every CT",
             "none"});
  if (body.has("spacing") && body.has("block"))
    body.fail("spacing", "a body has either spacing or block, not both");
  const toml::node* node = body.find("block");
  if (node && node->is_array())
    return body.read("block", block, within(1, 64, "voxels"), "voxels per lattice spacing; or `[x, y, z]`");
  int side = block.x;
  body.read("block", side, within(1, 64, "voxels"), "voxels per lattice spacing; or `[x, y, z]`");
  block = {side, side, side};
}

void read_fixed(SceneTable& body, lattice::Params& params, std::optional<HeldBy>& held) {
  const toml::node* node = body.find("fixed");
  body.describe(
      "fixed", "", "`\"bone\"`",
      "`\"bone\"`, `\"ends\"` (the layers of the scan nearest to head and feet), `[\"bone\", \"ends\"]`, "
      "`\"none\"`; or a table as for sfem, `{ sides = \"back\", depth = 0.3 }` or `{ box = … }`, relative to "
      "the box around the body's nodes");
  if (!node) return;

  // a table of sides or a box
  if (node->is_table()) {
    params.fix_bone = params.fix_ends = false;
    held = read_held(body);
    return;
  }
  const std::string expected =
      "\"bone\", \"ends\", [\"bone\", \"ends\"], \"none\", or { sides = \"back\", depth = 0.3 }";
  // one name or several
  std::vector<std::string> names;
  if (node->is_string()) {
    names.push_back(node->as_string()->get());
  } else if (node->is_array()) {
    for (const toml::node& name : *node->as_array()) names.push_back(name.value_or(std::string("?")));
  } else {
    return body.fail_value("fixed", *node, expected);
  }
  params.fix_bone = params.fix_ends = false;
  for (const std::string& name : names) {
    if (name == "bone")
      params.fix_bone = true;
    else if (name == "ends")
      params.fix_ends = true;
    else if (name != "none" || names.size() > 1)
      return body.fail_name("fixed", *node, expected, {"bone", "ends", "none"});
  }
}

void read_young_of_labels(SceneTable& tissue, SceneLabels& labels, lattice::TissueParams& params) {
  tissue.describe(
      "labels", "Pa", "none",
      "Young's modulus by label: `{ liver = 4e3, 77 = 8e3 }`; names are those of the file of `labels`, "
      "else those of TotalSegmentator (spleen, kidney_right, kidney_left, gallbladder, liver, stomach, "
      "pancreas, esophagus, small_bowel, duodenum, colon, urinary_bladder)");
  SceneTable table = tissue.table("labels");
  for (const std::string& name : table.keys()) {
    double young = 0;
    table.read(name, young, modulus(), "Young's modulus of this label");
    const int label = find_label(table, name, name, labels);
    if (label > 0 && young > 0) params.young_of_label[label] = young;
  }
}

/// One modulus for all tissues that have no modulus of their own.
void read_young(SceneTable& tissue, lattice::TissueParams& params) {
  double young = 0;
  tissue.read(
      "young", young, modulus(),
      {"one Young's modulus for gas, fat, muscle and bone; a tissue with its own key keeps its own", "none"});
  if (young > 0) params.gas = params.fat = params.muscle = params.bone = young;
}

/// Law of the tissue. A key that belongs to the other law is an error.
void read_law(SceneTable& tissue, const TissuePreset* preset, lattice::TissueParams& params,
              std::filesystem::path& fiber_field) {
  // law
  const std::string before = law_name(params);
  std::string law = before;
  tissue.read_choice(
      "law", law, {"springs", "solid", "exponential", "ogden"},
      "`\"solid\"`: isotropic neo-Hookean cells (`vbd` only, at least 2 sweeps); `\"exponential\"` and "
      "`\"ogden\"`: cells that stiffen with strain (docs/tissue-laws.md); `\"springs\"`: as in the "
      "paper, and the default with `pbd`");
  params.law = law == "springs" ? TissueLaw::kSprings : TissueLaw::kSolid;
  params.energy = law == "exponential" ? SolidEnergy::kExponential
                  : law == "ogden"     ? SolidEnergy::kOgden
                                       : SolidEnergy::kNeoHookean;
  read_stiffening(tissue, preset, params.energy, params.stiffening);
  read_fiber(tissue, params.energy, params.fiber, &fiber_field);
  // keys with limits
  tissue.read(
      "poisson", params.poisson, within(0, 0.499),
      "solid only: Poisson's ratio; above 0.45 an odd number of sweeps has one more; from 0.45 on, use 10 or "
      "more where tools press");
  tissue.read(
      "partial_cells", params.partial_cells,
      {"solid only: cells that the body fills in part bear in proportion, and skin bears where the CT shows "
       "it (docs/models/partial-cells.md)",
       "true where the laws support it"});
  tissue.read(
      "volume", params.volume, within(0, 100),
      "springs and vbd only: bulk stiffness of an added volume energy, in multiples of Young's modulus");
  // keys that the law does not support
  const bool solid = params.law == TissueLaw::kSolid;
  if (solid && tissue.has("volume"))
    tissue.fail("volume",
                "solid tissue, the default, keeps its volume by tissue.poisson; volume belongs to law = "
                "\"springs\": set that law, or remove volume");
  if (!solid && tissue.has("partial_cells"))
    tissue.fail("partial_cells", "springs join whole nodes: set law = \"solid\", or remove partial_cells");
  if (!solid && tissue.has("poisson"))
    tissue.fail("poisson", "springs have no Poisson's ratio: set law = \"solid\", or set volume");
  if (params.energy != SolidEnergy::kNeoHookean && params.partial_cells)
    tissue.fail("partial_cells",
                fmt::format("cells of law = \"{}\" are whole: remove partial_cells, or set law = "
                            "\"solid\"",
                            law));
}

/// Preset of a table, or of the short form `tissue = "liver"`.
const TissuePreset* read_preset_of(SceneTable& body, const char* key, SceneTable& table, PresetKind kind) {
  const TissuePreset* preset = read_preset(
      table, "preset", kind,
      kind == PresetKind::kSkin
          ? "a preset of `turgor tissues`: sets the keys of the skin that are not given; short form: `skin = "
            "\"skin-upper-arm\"`"
          : "a preset of `turgor tissues` for gas, fat, muscle and bone: sets the keys that are not given; "
            "short form: `tissue = \"liver\"`");
  const toml::node* node = body.find(key);
  return node && node->is_string() ? preset_of(body, key, kind) : preset;
}

/// Rows of the report: the modulus of every tissue, then those of labels.
void add_tissue_rows(SceneTable& tissue, const lattice::TissueParams& params, const TissuePreset* preset,
                     std::vector<TissueRow>& rows) {
  const char* law = law_name(params);
  const bool young = tissue.has("young");
  const std::pair<const char*, double> moduli[] = {
      {"gas", params.gas}, {"fat", params.fat}, {"muscle", params.muscle}, {"bone", params.bone}};
  for (const auto& [component, modulus] : moduli)
    rows.push_back(
        tissue_row(component, law, preset, {{"young", modulus, "Pa", young || tissue.has(component)}}));
  if (params.law == TissueLaw::kSolid)
    rows.push_back(
        tissue_row("all tissue", law, preset, {{"poisson", params.poisson, "1", tissue.has("poisson")}}));
  if (params.energy != SolidEnergy::kNeoHookean)
    rows.push_back(tissue_row("all tissue, stiffening", law, preset,
                              {stiffening_value(tissue, params.energy, params.stiffening)}));
  add_fiber_row(tissue, "all tissue", params.fiber, rows);
  for (const auto& [label, modulus] : params.young_of_label)
    rows.push_back(
        tissue_row(fmt::format("label {}", label), law, nullptr, {{"young", modulus, "Pa", true}}));
}

/// Viscosity: the given pairs; those of the preset if the table is there without pairs.
void read_relaxation(SceneTable& body, const TissuePreset* preset, lattice::TissueParams& params,
                     std::vector<TissueRow>& rows) {
  check_pairs_of_preset(body, preset);
  if (body.has("viscosity")) params.prony = prony_of(preset, {});
  read_viscosity(body.table("viscosity"), preset, params.prony, rows);
  if (pair_count(params.prony) == 0) return;
  if (params.law != TissueLaw::kSolid)
    body.fail("viscosity", "springs do not relax: set tissue.law = \"solid\", or remove viscosity");
  if (params.partial_cells)
    body.fail("viscosity", "viscous cells are whole: remove tissue.partial_cells, or viscosity");
}

void read_tissue(SceneTable& body, SceneLabels& labels, lattice::TissueParams& params,
                 std::filesystem::path& fiber_field, LayerExtras& extras, std::vector<TissueRow>& rows) {
  // a preset for all tissues
  SceneTable tissue = body.table_or_text("tissue");
  const TissuePreset* preset = read_preset_of(body, "tissue", tissue, PresetKind::kSolid);
  for (double* modulus : {&params.gas, &params.fat, &params.muscle, &params.bone})
    *modulus = value_or(preset, "young", *modulus);
  // stiffness per tissue, thresholds of CT values
  read_young(tissue, params);
  tissue.read("gas", params.gas, modulus(), "Young's modulus of gas inside the body");
  tissue.read("fat", params.fat, modulus(), "of fat");
  tissue.read("muscle", params.muscle, modulus(), "of muscle and organs");
  tissue.read("bone", params.bone, modulus(), "of bone that is not fixed");
  tissue.read("air_max", params.air_max, within(-1024, 3071, "HU"), "below is air");
  tissue.read("fat_max", params.fat_max, within(-1024, 3071, "HU"), "below is fat");
  tissue.read("bone_min", params.bone_min, within(-1024, 3071, "HU"), "above is bone");
  // law and stiffness per label
  read_law(tissue, preset, params, fiber_field);
  read_young_of_labels(tissue, labels, params);
  // check consistency
  if (params.air_max >= params.fat_max || params.fat_max >= params.bone_min)
    tissue.fail("", fmt::format("expected air_max < fat_max < bone_min, found {} < {} < {} HU",
                                params.air_max, params.fat_max, params.bone_min));
  if (!params.young_of_label.empty() && !has_labels(body))
    tissue.fail("labels", "stiffness by label needs a segmentation: add labels = \"seg.nii.gz\" to the body");
  tissue.finish();
  add_tissue_rows(tissue, params, preset, rows);
  read_layers(body, has_labels(body), labels, params, extras, rows);
  read_relaxation(body, preset, params, rows);
  read_permanent_set(body, params, rows);
}

void read_tension(SceneTable& table, lattice::SkinParams& skin) {
  // describe the key
  const toml::node* node = table.find("tension");
  table.describe("tension", "N/m", "45",
                 "a number, or `[along, across]` Langer's lines: the skin's tension in the CT; less than the "
                 "stiffness. Measured tension of living skin is 6 to 138 N/m",
                 not_negative("N/m"));
  if (!node) return;
  // one number: isotropic tension
  if (!node->is_array()) {
    table.read("tension", skin.tension_along, not_negative("N/m"),
               "a number, or `[along, across]` Langer's lines: the skin's tension in the CT; less than the "
               "stiffness");
    skin.tension_across = skin.tension_along;
    return;
  }
  // two numbers: along and across Langer's lines
  if (node->as_array()->size() != 2)
    return table.fail_value("tension", *node, "a number or [along, across] Langer's lines [N/m]");
  const std::vector<double> tension = table.numbers("tension", *node, not_negative("N/m"));
  if (tension.size() == 2) skin.tension_along = tension[0], skin.tension_across = tension[1];
}

void read_skin(SceneTable& body, lattice::SkinParams& skin, std::filesystem::path& field,
               std::vector<TissueRow>& rows) {
  // short form: true or false
  const toml::node* node = body.find("skin");
  if (node && node->is_boolean()) {
    skin.enabled = node->as_boolean()->get();
    return;
  }
  // keys with limits
  SceneTable table = body.table_or_text("skin");
  const TissuePreset* preset = read_preset_of(body, "skin", table, PresetKind::kSkin);
  apply_skin_preset(preset, skin);
  table.read_choice<SkinLaw>(
      "law", skin.law,
      {{"area", SkinLaw::kArea}, {"fiber", SkinLaw::kFiber}, {"exponential", SkinLaw::kExponential}},
      "`\"fiber\"`: directional, with Langer's lines; `\"area\"`: the paper's; "
      "`\"exponential\"`: stiffens as measured skin does (docs/skin-law.md)");
  check_skin_preset(body, preset, skin);
  read_tension(table, skin);
  read_skin_stiffness(table, skin);
  table.read("direction", skin.direction, any_number("1"), "Langer's lines, for the whole body");
  table.read_path("direction_field", field, "Langer's lines as a three-component image on the same patient");
  // check consistency
  if (norm(skin.direction) == 0) table.fail("direction", "expected a vector that is not zero");
  check_skin_tension(table, skin);
  table.finish();
  add_skin_rows(table, skin, preset, rows);
}

void read_solver(SceneTable& body, lattice::SolverParams& solver) {
  // method and order of a sweep
  SceneTable table = body.table("solver");
  table.read_choice<Method>(
      "method", solver.method, {{"pbd", Method::kPbd}, {"vbd", Method::kVbd}},
      "`\"vbd\"`: vertex block descent; `\"pbd\"`: position-based dynamics as in the paper, area law only");
  table.read_choice<Ordering>(
      "ordering", solver.ordering, {{"slabs", Ordering::kSlabs}, {"colors", Ordering::kColors}},
      "the order of a sweep: `\"slabs\"` of layers, fastest on a CPU, or eight `\"colors\"` by the parity of "
      "node indices, each solved in parallel, as a GPU needs it (its default there). The rest state of vbd "
      "does not depend on it, that of pbd does");
  // keys with limits
  table.read("sweeps", solver.sweeps, within(1, 1000), "per frame");
  table.read("damping", solver.damping, not_negative("1/s"), "velocities decay by exp(−damping · t)");
  table.read(
      "sleep_speed", solver.sleep_speed, not_negative("m/s"),
      "vbd on the CPU only: a row of nodes sleeps, and is not swept, after eight frames in which nothing "
      "near "
      "it was faster. It wakes when something near it moves, is cut, touched or loaded; 0: no row sleeps");
  // keys of single methods
  table.read("pbd_stiffness", solver.pbd_stiffness, within(0, 1),
             "pbd only: scales the density-based stiffness");
  table.read("pbd_volume", solver.pbd_volume, "pbd only: preserve the volumes of tetrahedra");
  table.read("coarse", solver.coarse,
             "solid and vbd only: adds a coarse correction (two-level VBD) for smooth errors");
  table.finish();
}

}  // namespace

LatticeScene read_lattice_scene(SceneTable body, const std::string& name, Device device) {
  LatticeScene scene{.device = device};
  body.begin_group("lattice");
  scene.name = name, scene.source_location = body.location();

  // CT, labels and lattice
  scene.ct = read_ct_source(body);
  body.read_path("labels", scene.labels,
                 "a segmentation of the same patient on the CT's grid, for `tissue.labels`, `layers` and "
                 "`only`; the file names "
                 "its labels (`.seg.nrrd`, or a NIfTI extension), else they are TotalSegmentator's");
  SceneLabels labels = scene_labels(body);
  read_block(body, scene.params.block, scene.spacing);
  read_only(body, labels, scene);
  read_fixed(body, scene.params, scene.held);
  body.read("gravity", scene.has_gravity,
            "`false`: the CT shows the body as gravity has already shaped it; only loads on it act");

  // solver and tissue
  if (device == Device::kGpu) scene.params.solver.ordering = Ordering::kColors;
  read_solver(body, scene.params.solver);
  const bool projects = scene.params.solver.method == Method::kPbd;
  scene.params.tissue.law = projects ? TissueLaw::kSprings : TissueLaw::kSolid;
  LayerExtras layers;
  read_tissue(body, labels, scene.params.tissue, scene.fiber_field, layers, scene.tissues);
  scene.inside = read_needle_layers(body, has_labels(body), labels);
  scene.inside.insert(scene.inside.end(), layers.tough.begin(), layers.tough.end());
  scene.layer_colors = std::move(layers.colors);
  read_stiffness_scale(body, scene.stiffness_scale);
  if (projects && scene.stiffness_scale != 1)
    body.fail("stiffness_scale", "solver.method = \"pbd\" has no moduli to scale; expected 1");
  scene.label_note = labels.note;

  // skin
  read_skin(body, scene.params.skin, scene.direction_field, scene.tissues);
  const bool has_fibers = scene.params.skin.enabled && scene.params.skin.law != SkinLaw::kArea;
  if (projects && has_fibers)
    body.fail(body.has("skin") ? "skin" : "solver",
              "solver.method = \"pbd\" offers the area law only (a projection has no forces along and across "
              "Langer's lines); set skin.law = \"area\" or solver.method = \"vbd\"");
  read_texture(body, scene.texture);

  // combinations
  const lattice::TissueParams& law = scene.params.tissue;
  if (!scene.fiber_field.empty() && !lattice::has_fibers(law))
    body.fail("tissue",
              "fiber.direction_field needs fibers: set fiber.stiffness of the tissue or of a layer");
  if (scene.params.solver.sleep_speed > 0 && (lattice::most_pairs(law) > 0 || lattice::has_set(law.set)))
    body.fail(
        pair_count(law.prony) > 0      ? "viscosity"
        : lattice::most_pairs(law) > 0 ? "layers"
                                       : "permanent_set",
        "tissue that relaxes or sets creeps in its sleep: set solver.sleep_speed = 0, or remove the key");
  check_solid(body, scene.params);
  choose_cells(body, scene);
  if (device == Device::kGpu) check_gpu(body, scene.params);
  body.finish();
  return scene;
}

}  // namespace turgor

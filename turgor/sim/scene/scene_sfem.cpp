#include "turgor/sim/scene/scene_sfem.hpp"

#include "turgor/core/number_text.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_held.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_prony.hpp"
#include "turgor/sim/scene/scene_solid_source.hpp"
#include "turgor/sim/scene/scene_texture.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kToughness = within(-1, 1e5, "J/m²");
const Meaning kToughnessMeaning{"against needles; -1 is the default",
                                "that of the needle's `shape.toughness`"};

UpAxis up_of(const SolidSource& source) {
  if (const auto* solid = std::get_if<SolidFile>(&source)) return solid->up;
  if (const auto* surface = std::get_if<ClosedSurface>(&source)) return surface->up;
  return UpAxis::kZ;
}

constexpr const char* kTissueMeaning =
    "a preset of `turgor tissues`, such as `\"liver\"`: sets the keys of the material that are not given";

void read_young_and_poisson(SceneTable& table, sfem::Material& material) {
  table.read("young", material.young, modulus(), "Young's modulus");
  const toml::node* node = table.find("poisson");
  table.describe("poisson", "", number_text(material.poisson).c_str(), "Poisson's ratio", inside(-1, 0.5));
  if (!node) return;
  const auto value = node->is_number() ? node->value<double>() : std::nullopt;
  if (value && *value >= 0.5)  // the usual mistake has its own message
    return table.fail(
        "poisson", fmt::format("expected below 0.5 (0.5 is incompressible with infinite bulk modulus; 0.49 "
                               "is nearly incompressible), found {}",
                               *value));
  table.read("poisson", material.poisson, inside(-1, 0.5), "Poisson's ratio");
}

/// Material from a preset and its own keys, and its row in the report. Returns the preset or null.
const TissuePreset* read_material(SceneTable& table, const std::string& component, sfem::Material& material,
                                  std::vector<TissueRow>& rows) {
  const TissuePreset* preset = read_preset(table, "tissue", PresetKind::kSolid, kTissueMeaning);
  material.young = value_or(preset, "young", material.young);
  read_young_and_poisson(table, material);
  rows.push_back(tissue_row(component, "linear", preset,
                            {{"young", material.young, "Pa", table.has("young")},
                             {"poisson", material.poisson, "1", table.has("poisson")}}));
  return preset;
}

/// Fixed vertices, or none.
void read_free(SceneTable& body, SfemScene& scene) {
  const toml::node* node = body.find("fixed");
  scene.is_free = node && node->value_or(std::string()) == "none";
  scene.fixed = scene.is_free ? HeldBy{.sides = {}} : read_held(body);
  body.read(
      "density", scene.density, inside(1, 1e5, "kg/m³"),
      "mass per volume of a body with `fixed = \"none\"`: no vertex is fixed, it moves with its inertia "
      "and feels `world.gravity`; attachments and contacts hold it");
  if (!scene.is_free) return;
  // limits of bodies that move
  if (scene.stiffness_scale != 1)
    body.fail("stiffness_scale",
              "a body with fixed = \"none\" has no stiffness_scale, which would change its "
              "mass too: change young");
  if (body.has("rotations"))
    body.fail("rotations", "rotations are not computed for a body with fixed = \"none\": remove the key");
}

/// Element order. Elements with a formulation are linear, and so are hexahedra.
void read_elements(SceneTable& body, SfemScene& scene) {
  // element order; quadratic by default
  scene.elements = Elements::kQuadratic;
  body.read_choice<Elements>("elements", scene.elements,
                             {{"linear", Elements::kLinear}, {"quadratic", Elements::kQuadratic}},
                             {"`\"quadratic\"` tetrahedra have eight times the nodes on the same mesh, and "
                              "converged forces at twice "
                              "the edge length; `\"linear\"` ones are 15 to 38 % too stiff",
                              "`\"quadratic\"`; `\"linear\"` for hexahedra and with a `formulation`"});
  // reject keys that exclude quadratic elements
  const bool explicitly_quadratic = body.has("elements") && scene.elements == Elements::kQuadratic;
  if (explicitly_quadratic && std::holds_alternative<HexBlock>(scene.source))
    body.fail("elements",
              "\"quadratic\" elements are tetrahedra, a block consists of hexahedra: remove `elements`, and "
              "set formulation = \"averaged\" for tissue near ν = 0.5");
  if (explicitly_quadratic && body.has("formulation"))
    body.fail("formulation", "quadratic elements have one formulation, which does not lock: remove this key");
  // hexahedra and explicit formulations are linear
  if (body.has("formulation") || std::holds_alternative<HexBlock>(scene.source))
    scene.elements = Elements::kLinear;
}

/// Position in meters, or in fractions of the body's box. Returns true for fractions.
bool read_position(SceneTable& table, const std::string& key, Vec3d& position) {
  const std::string by_fraction = key + "_fraction";
  table.require({key, by_fraction}, "a position [m], or in fractions of the body's box");
  if (table.has(key) && table.has(by_fraction))
    table.fail(key, "a position is given either in meters or in fractions, not in both");
  table.read(key, position, within(-100, 100, "m"), {"center of a sphere of another material", "required"});
  table.read(by_fraction, position, within(0, 1), {"instead: in fractions of the body's box", "none"});
  return table.has(by_fraction);
}

std::vector<InsideScene> read_inside(SceneTable& body, const sfem::Material& around, SceneLabels& labels,
                                     std::vector<TissueRow>& rows) {
  std::vector<InsideScene> regions;
  SceneTable table = body.table("inside");
  for (const std::string& name : table.names()) {
    // the material defaults to that of the body
    InsideScene region{name, 0, around};
    SceneTable inner = table.named(name);
    inner.require({"label"}, "the label of its elements in the file or the segmentation");
    read_label(inner, "label", labels, region.label,
               "elements with this label, a number or a name, have another material; `young` and `poisson` "
               "default to those of the body");
    read_material(inner, "inside." + name, region.material, rows);
    inner.read("toughness", region.toughness, kToughness, kToughnessMeaning);
    inner.finish();
    regions.push_back(region);
  }
  return regions;
}

std::vector<InclusionScene> read_inclusions(SceneTable& body, const sfem::Material& around,
                                            std::vector<TissueRow>& rows) {
  std::vector<InclusionScene> inclusions;
  SceneTable table = body.table("inclusion");
  for (const std::string& name : table.names()) {
    // the material defaults to that of the body
    InclusionScene inclusion{
        .name = name, .center = {}, .by_fraction = false, .radius = 0.01, .material = around};
    SceneTable inner = table.named(name);
    // keys with limits
    inclusion.by_fraction = read_position(inner, "center", inclusion.center);
    inner.read("radius", inclusion.radius, inside(0, 10, "m"), "radius of a sphere of another material");
    read_material(inner, "inclusion." + name, inclusion.material, rows);
    inner.read("toughness", inclusion.toughness, kToughness, kToughnessMeaning);
    inner.finish();
    inclusions.push_back(inclusion);
  }
  return inclusions;
}

void read_patch(SceneTable& body, PatchScene& patch) {
  // short form: false disables the patch
  const toml::node* node = body.find("patch");
  body.describe("patch", "", "", "refined mesh around the tool, a table of the keys below; `false`: none");
  if (node && node->is_boolean()) {
    if (!node->as_boolean()->get()) patch.refinement = 1, patch.radius_is_open = true;
    return;
  }
  // keys with limits
  SceneTable table = body.table("patch");
  patch.radius_is_open = !table.has("radius");
  table.read("radius", patch.radius, inside(0, 1, "m"),
             {"radius of the refined mesh around the tool",
              "0.02; with quadratic elements, or where memory is short, chosen by the expected force error"});
  if (!table.has("refinement")) patch.refinement = kByElements;
  table.read("refinement", patch.refinement, within(1, 4),
             {"number of segments per edge; 1 = no refinement",
              "2; for quadratic elements, chosen so that the expected force error is at most 4 %"});
  table.read("hysteresis", patch.hysteresis, within(0, 1),
             "distance that the contact moves before the patch follows, relative to the radius");
  table.finish();
}

/// True if the body names a law that its elements do not relax with. The pairs of its preset are then unused.
bool names_law(SceneTable& body) {
  const toml::node* node = body.find("law");
  return node && node->value_or(std::string("linear")) != "linear";
}

/// Law of the patch, and the keys that exclude it.
void read_law(SceneTable& body, const TissuePreset* preset, SfemScene& scene) {
  enum class Kind { kLinear, kNeoHookean, kExponential };
  Kind kind = Kind::kLinear;
  body.read_choice<Kind>(
      "law", kind,
      {{"linear", Kind::kLinear}, {"neo_hookean", Kind::kNeoHookean}, {"exponential", Kind::kExponential}},
      "law of the elements in the patch under the tool: `\"linear\"`, `\"neo_hookean\"` or "
      "`\"exponential\"`; the rest of the body is linear");
  double stiffening = value_or(preset, "stiffening", 5);
  body.read(
      "stiffening", stiffening, within(0.01, 1000, "1"),
      "with law = \"exponential\": exponent b of Ψ = µ/2b (exp(b (Ī₁ − 3)) − 1); a preset may have one");
  if (kind != Kind::kExponential && body.has("stiffening"))
    body.fail("stiffening", "expected law = \"exponential\" beside it, found another law");
  if (kind == Kind::kLinear) return;
  scene.law = sfem::Law{kind == Kind::kExponential ? stiffening : 0};
  if (kind == Kind::kExponential)
    scene.tissues.push_back(tissue_row("body, law of the patch", "exponential", preset,
                                       {{"stiffening", stiffening, "1", body.has("stiffening")}}));
  const auto exclude = [&](bool found, const char* other) {
    if (found) body.fail("law", fmt::format("a nonlinear law and {} are not computed together", other));
  };
  exclude(scene.rotations, "rotations = true");
  exclude(pair_count(scene.viscosity) > 0, "viscosity");
  exclude(scene.is_free, "fixed = \"none\"");
  exclude(scene.formulation == sfem::Formulation::kAveraged, "formulation = \"averaged\"");
}

/// Refuses elements that lock. Cook's panel of linear elements keeps less than 0.7 of its deflection at 0.49,
/// and 0.4 at 0.499; averaged and quadratic ones keep 0.9.
void check_locking(SceneTable& body, const SfemScene& scene) {
  constexpr double kLargest = 0.49;
  double poisson = scene.material.poisson;
  for (const InsideScene& one : scene.inside) poisson = std::max(poisson, one.material.poisson);
  for (const InclusionScene& one : scene.inclusions) poisson = std::max(poisson, one.material.poisson);
  if (poisson <= kLargest || scene.elements != Elements::kLinear ||
      scene.formulation == sfem::Formulation::kAveraged)
    return;
  body.fail("poisson",
            fmt::format("expected at most {} with linear elements, which lock beyond; found {}: add "
                        "formulation = \"averaged\" or elements = \"quadratic\"",
                        kLargest, poisson));
}

void read_cache(SceneTable& body, SfemScene& scene) {
  constexpr const char* kMeaning =
      "folder below the user's cache folder in which Green's functions are cached between runs; `--set` may "
      "choose any folder; `false`: no cache";
  const toml::node* node = body.find("cache");
  body.describe("cache", "", "the user's cache folder", kMeaning);
  if (node && node->is_boolean())
    scene.cached = node->as_boolean()->get();
  else
    body.read_cache_folder("cache", scene.cache, {kMeaning, "the user's cache folder"});
}

}  // namespace

SfemScene read_sfem_scene(SceneTable body, const std::string& name, Device device) {
  SfemScene scene;
  scene.device = device;
  body.begin_group("sfem");
  scene.name = name, scene.source_location = body.location();

  // shape and materials
  SceneLabels labels = scene_labels(body);
  scene.source = read_solid_source(body, labels);
  const TissuePreset* tissue = read_material(body, "body", scene.material, scene.tissues);
  read_stiffness_scale(body, scene.stiffness_scale);
  scene.inside = read_inside(body, scene.material, labels, scene.tissues);
  if (auto* organ = std::get_if<LabeledOrgan>(&scene.source)) organ->label_note = labels.note;
  scene.inclusions = read_inclusions(body, scene.material, scene.tissues);

  // fixed vertices and elements
  read_free(body, scene);
  read_elements(body, scene);
  body.read_choice<sfem::Formulation>(
      "formulation", scene.formulation,
      {{"standard", sfem::Formulation::kStandard}, {"averaged", sfem::Formulation::kAveraged}},
      "`\"averaged\"`: volumes are averaged around nodes, so that tissue near ν = 0.5 does not lock");
  body.read_choice<sfem::Precision>(
      "precision", scene.precision,
      {{"single", sfem::Precision::kSingle}, {"double", sfem::Precision::kDouble}},
      "precision of the stored Green's functions: `\"single\"` or `\"double\"`");

  check_locking(body, scene);

  // patch and time behavior
  read_patch(body, scene.patch);
  if (!names_law(body)) scene.viscosity = prony_of(tissue, scene.viscosity);
  read_viscosity(body.table("viscosity"), tissue, scene.viscosity, scene.tissues);

  body.read("rotations", scene.rotations,
            "removes large rotations from the strain, so that a deep press does not swell");
  read_law(body, tissue, scene);
  read_texture(body, scene.texture);

  // memory and cache
  body.read(
      "memory", scene.memory, within(0.001, 1024, "GB"),
      "limit for Green's functions; beyond it, columns are computed on demand at the tools. Building a patch "
      "has the same limit, at least 0.25 GB. A first patch that fits is chosen, unless `patch` sets it; a "
      "later "
      "patch that exceeds it is not built, the previous one stays, and the report says so");
  body.read("contacts", scene.contacts, within(8, 512),
            "contact sites that a tick solves, all tools together. A tool that touches more vertices is "
            "represented by clusters of them, which costs accuracy (a few percent) but no time. The time "
            "grows with the cube of the number of sites");
  read_cache(body, scene);

  // drawn surface
  body.read_path("seen", scene.seen,
                 "a finer surface that is embedded in the body and drawn instead (OBJ, STL, PLY, VTP, VTK)");
  body.read("seen_scale", scene.seen_scale, inside(0, 1e6, "m"), "meters per unit of that file");
  scene.seen_up = up_of(scene.source);  // both files are likely to come from one program
  read_up(body, "seen_up", scene.seen_up);
  body.finish();
  return scene;
}

}  // namespace turgor

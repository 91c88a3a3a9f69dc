#include "turgor/sim/scene/scene_sfem.hpp"

#include "turgor/sim/scene/scene_ct.hpp"
#include "turgor/sim/scene/scene_held.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kResolution = within(1e-4, 1, "m");
const Allowed kScale = inside(0, 1e6, "m");

LabelledOrgan read_labelled_organ(SceneTable& table, SceneLabels& names) {
  LabelledOrgan organ;
  const toml::node* labels = table.find("labels");
  if (labels->is_table())
    organ.phantom = read_phantom(table.table("labels"));
  else
    table.read_path("labels", organ.file);
  table.require({"label"}, "which label is the body: a number, or a name such as \"liver\"");
  read_label(table, "label", names, organ.label);
  table.read("resolution", organ.resolution, kResolution);
  return organ;
}

HexBlock read_hex_block(SceneTable table) {
  HexBlock block;
  table.require({"size"}, "the block's size, [x, y, z] [m]");
  table.require({"count"}, "hexahedra along x, y and z");
  table.read("size", block.size, inside(0, 100, "m"));
  table.read("count", block.count, within(1, 200));
  table.finish();
  return block;
}

SolidSource read_source(SceneTable& body, SceneLabels& labels) {
  const std::vector<std::string> kinds = {"mesh", "surface", "labels", "block"};
  body.require(kinds, "where the body's shape comes from");
  std::string given;
  for (const std::string& kind : kinds) {
    if (!body.has(kind)) continue;
    if (!given.empty()) body.fail(kind, fmt::format("a body has one shape: either {} or {}", given, kind));
    given = given.empty() ? kind : given;
  }
  if (given == "labels") return read_labelled_organ(body, labels);
  if (given == "block") return read_hex_block(body.table("block"));
  if (given == "surface") {
    ClosedSurface surface;
    body.read_path("surface", surface.file);
    body.read("scale", surface.scale, kScale);
    read_up(body, "up", surface.up);
    body.read("resolution", surface.resolution, kResolution);
    return surface;
  }
  SolidFile solid;
  body.read_path("mesh", solid.file);
  body.read("scale", solid.scale, kScale);
  read_up(body, "up", solid.up);
  return solid;
}

UpAxis up_of(const SolidSource& source) {
  if (const auto* solid = std::get_if<SolidFile>(&source)) return solid->up;
  if (const auto* surface = std::get_if<ClosedSurface>(&source)) return surface->up;
  return UpAxis::kZ;
}

void read_material(SceneTable& table, sfem::Material& material) {
  table.read("young", material.young, positive("Pa"));
  const toml::node* node = table.find("poisson");
  if (!node) return;
  const auto value = node->is_number() ? node->value<double>() : std::nullopt;
  if (value && *value >= 0.5)  // the usual mistake deserves its own sentence
    return table.fail(
        "poisson", fmt::format("expected below 0.5 (at 0.5 nothing can change its volume, and the stiffness "
                               "is infinite; 0.49 is nearly that), found {}",
                               *value));
  table.read("poisson", material.poisson, inside(-1, 0.5));
}

/// A place in metres, or in fractions of the body's box; `key_fraction` says which.
bool read_place(SceneTable& table, const std::string& key, Vec3d& place) {
  const std::string by_fraction = key + "_fraction";
  table.require({key, by_fraction}, "a place [m], or in fractions of the body's box");
  if (table.has(key) && table.has(by_fraction))
    table.fail(key, "a place is given either in metres or in fractions, not in both");
  table.read(key, place, within(-100, 100, "m"));
  table.read(by_fraction, place, within(0, 1));
  return table.has(by_fraction);
}

std::vector<InsideScene> read_inside(SceneTable& body, const sfem::Material& around, SceneLabels& labels) {
  std::vector<InsideScene> parts;
  SceneTable table = body.table("inside");
  for (const std::string& name : table.names()) {
    InsideScene part{name, 0, around};
    SceneTable inner = table.table(name);
    inner.require({"label"}, "the number of its elements in the file or the segmentation");
    read_label(inner, "label", labels, part.label);
    read_material(inner, part.material);
    inner.finish();
    parts.push_back(part);
  }
  return parts;
}

std::vector<InclusionScene> read_inclusions(SceneTable& body, const sfem::Material& around) {
  std::vector<InclusionScene> inclusions;
  SceneTable table = body.table("inclusion");
  for (const std::string& name : table.names()) {
    InclusionScene inclusion{
        .name = name, .centre = {}, .by_fraction = false, .radius = 0.01, .material = around};
    SceneTable inner = table.table(name);
    inclusion.by_fraction = read_place(inner, "centre", inclusion.centre);
    inner.read("radius", inclusion.radius, inside(0, 10, "m"));
    read_material(inner, inclusion.material);
    inner.finish();
    inclusions.push_back(inclusion);
  }
  return inclusions;
}

void read_patch(SceneTable& body, PatchScene& patch) {
  const toml::node* node = body.find("patch");
  if (node && node->is_boolean()) {
    if (!node->as_boolean()->get()) patch.refinement = 1;
    return;
  }
  SceneTable table = body.table("patch");
  table.read("radius", patch.radius, inside(0, 1, "m"));
  table.read("refinement", patch.refinement, within(1, 4));
  table.read("hysteresis", patch.hysteresis, within(0, 1));
  table.finish();
}

void read_cache(SceneTable& body, SfemScene& scene) {
  const toml::node* node = body.find("cache");
  if (node && node->is_boolean())
    scene.cached = node->as_boolean()->get();
  else
    body.read_path("cache", scene.cache);
}

}  // namespace

SfemScene read_sfem_scene(SceneTable body, const std::string& name) {
  SfemScene scene;
  scene.name = name, scene.place = body.place();
  SceneLabels labels = scene_labels(body);
  scene.source = read_source(body, labels);
  read_material(body, scene.material);
  scene.inside = read_inside(body, scene.material, labels);
  if (auto* organ = std::get_if<LabelledOrgan>(&scene.source)) organ->label_note = labels.note;
  scene.inclusions = read_inclusions(body, scene.material);
  scene.fixed = read_held(body);
  body.read_choice<sfem::Formulation>(
      "formulation", scene.formulation,
      {{"standard", sfem::Formulation::kStandard}, {"averaged", sfem::Formulation::kAveraged}});
  body.read_choice<sfem::Precision>(
      "precision", scene.precision,
      {{"single", sfem::Precision::kSingle}, {"double", sfem::Precision::kDouble}});
  read_patch(body, scene.patch);
  SceneTable viscosity = body.table("viscosity");
  viscosity.read("ratio", scene.viscosity, within(0, 100));
  viscosity.read("time", scene.viscous_time, inside(0, 1000, "s"));
  viscosity.finish();
  body.read("rotations", scene.rotations);
  body.read("memory", scene.memory, within(0.001, 1024, "GB"));
  body.read("contacts", scene.contacts, within(8, 512));
  read_cache(body, scene);
  body.read_path("seen", scene.seen);
  body.read("seen_scale", scene.seen_scale, kScale);
  scene.seen_up = up_of(scene.source);  // of one organ, most likely from one program
  read_up(body, "seen_up", scene.seen_up);
  body.finish();
  return scene;
}

}  // namespace turgor

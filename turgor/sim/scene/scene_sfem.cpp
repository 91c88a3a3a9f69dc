#include "turgor/sim/scene/scene_sfem.hpp"

#include "turgor/core/number_text.hpp"
#include "turgor/sim/scene/scene_ct.hpp"
#include "turgor/sim/scene/scene_held.hpp"
#include "turgor/sim/scene/scene_label.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kResolution = within(1e-4, 1, "m");
constexpr double kUsualEdge = 0.02;  // of quadratic tetrahedra: nodes lie half as far apart [m]
const Allowed kScale = inside(0, 1e6, "m");

LabeledOrgan read_labeled_organ(SceneTable& table, SceneLabels& names) {
  LabeledOrgan organ;
  organ.resolution = kUsualEdge;
  const toml::node* labels = table.find("labels");
  if (labels->is_table())
    organ.phantom = read_phantom(table.table("labels"));
  else
    table.read_path(
        "labels", organ.file,
        {"a segmentation, one label of which is filled with tetrahedra: a file, or `{ phantom = \"torso\" }`",
         "none"});
  table.require({"label"}, "which label is the body: a number, or a name such as \"liver\"");
  read_label(
      table, "label", names, organ.label,
      {"a number, or the name that the file of `labels` gives it, or if it names none that TotalSegmentator "
       "gives it, such as `\"liver\"`; the nodule of the phantom is `\"nodule\"`",
       "required with `labels`"});
  table.read("resolution", organ.resolution, kResolution,
             "with `surface` and `labels`: about the edge length of the tetrahedra");
  return organ;
}

HexBlock read_hex_block(SceneTable table) {
  HexBlock block;
  table.require({"size"}, "the block's size, [x, y, z] [m]");
  table.require({"count"}, "hexahedra along x, y and z");
  table.read("size", block.size, inside(0, 100, "m"),
             "of hexahedra from the origin, for comparison with theory");
  table.read("count", block.count, within(1, 200), "hexahedra along x, y and z");
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
  if (given == "labels") return read_labeled_organ(body, labels);
  if (given == "block") return read_hex_block(body.table("block"));
  if (given == "surface") {
    ClosedSurface surface;
    surface.resolution = kUsualEdge;
    body.read_path("surface", surface.file,
                   {"or a closed surface, filled with tetrahedra: OBJ, STL, PLY, VTP, VTK", "none"});
    body.read("scale", surface.scale, kScale,
              "with `mesh` and `surface`: metres a unit of the file; 0.001 for a file in mm");
    read_up(body, "up", surface.up);
    body.read("resolution", surface.resolution, kResolution,
              "with `surface` and `labels`: about the edge length of the tetrahedra");
    return surface;
  }
  SolidFile solid;
  body.read_path("mesh", solid.file,
                 {"a file of tetrahedra or hexahedra: Gmsh, VTK, VTU, TetGen, Medit",
                  "one of `mesh`, `surface`, `labels`, `block`"});
  body.read("scale", solid.scale, kScale,
            "with `mesh` and `surface`: metres a unit of the file; 0.001 for a file in mm");
  read_up(body, "up", solid.up);
  return solid;
}

UpAxis up_of(const SolidSource& source) {
  if (const auto* solid = std::get_if<SolidFile>(&source)) return solid->up;
  if (const auto* surface = std::get_if<ClosedSurface>(&source)) return surface->up;
  return UpAxis::kZ;
}

void read_material(SceneTable& table, sfem::Material& material) {
  table.read("young", material.young, positive("Pa"), "Young's modulus");
  const toml::node* node = table.find("poisson");
  table.describe("poisson", "", number_text(material.poisson).c_str(), "Poisson's ratio", inside(-1, 0.5));
  if (!node) return;
  const auto value = node->is_number() ? node->value<double>() : std::nullopt;
  if (value && *value >= 0.5)  // the usual mistake deserves its own sentence
    return table.fail(
        "poisson", fmt::format("expected below 0.5 (at 0.5 nothing can change its volume, and the stiffness "
                               "is infinite; 0.49 is nearly that), found {}",
                               *value));
  table.read("poisson", material.poisson, inside(-1, 0.5), "Poisson's ratio");
}

/// Elements with a formulation are linear, and so are hexahedra, which nobody can ask to be otherwise.
void read_elements(SceneTable& body, SfemScene& scene) {
  scene.elements = Elements::kQuadratic;
  body.read_choice<Elements>(
      "elements", scene.elements, {{"linear", Elements::kLinear}, {"quadratic", Elements::kQuadratic}},
      {"tetrahedra whose edges bend (`\"quadratic\"`) have eight times the nodes on the same mesh, and the "
       "right "
       "force on one of twice the edge length; `\"linear\"` ones are up to a third too stiff",
       "`\"quadratic\"`; `\"linear\"` for hexahedra and with a `formulation`"});
  const bool asked = body.has("elements") && scene.elements == Elements::kQuadratic;
  if (asked && std::holds_alternative<HexBlock>(scene.source))
    body.fail("elements",
              "\"quadratic\" ones are tetrahedra, a block is of hexahedra: leave `elements` out, and "
              "take formulation = \"averaged\" for tissue near ν = 0.5");
  if (asked && body.has("formulation"))
    body.fail("formulation", "quadratic elements have one formulation, which does not lock: leave it out");
  if (body.has("formulation") || std::holds_alternative<HexBlock>(scene.source))
    scene.elements = Elements::kLinear;
}

/// A place in metres, or in fractions of the body's box; `key_fraction` says which.
bool read_place(SceneTable& table, const std::string& key, Vec3d& place) {
  const std::string by_fraction = key + "_fraction";
  table.require({key, by_fraction}, "a place [m], or in fractions of the body's box");
  if (table.has(key) && table.has(by_fraction))
    table.fail(key, "a place is given either in metres or in fractions, not in both");
  table.read(key, place, within(-100, 100, "m"), {"the middle of a sphere of another material", "required"});
  table.read(by_fraction, place, within(0, 1), {"instead: in fractions of the body's box", "none"});
  return table.has(by_fraction);
}

std::vector<InsideScene> read_inside(SceneTable& body, const sfem::Material& around, SceneLabels& labels) {
  std::vector<InsideScene> parts;
  SceneTable table = body.table("inside");
  for (const std::string& name : table.names()) {
    InsideScene part{name, 0, around};
    SceneTable inner = table.named(name);
    inner.require({"label"}, "the number of its elements in the file or the segmentation");
    read_label(inner, "label", labels, part.label,
               "another material where the file or the segmentation has this number, or name; `young` and "
               "`poisson` that are not given are the body's");
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
        .name = name, .center = {}, .by_fraction = false, .radius = 0.01, .material = around};
    SceneTable inner = table.named(name);
    inclusion.by_fraction = read_place(inner, "centre", inclusion.center);
    inner.read("radius", inclusion.radius, inside(0, 10, "m"), "of a sphere of another material");
    read_material(inner, inclusion.material);
    inner.finish();
    inclusions.push_back(inclusion);
  }
  return inclusions;
}

void read_patch(SceneTable& body, PatchScene& patch) {
  const toml::node* node = body.find("patch");
  body.describe("patch", "", "", "the finer mesh where the tool is, a table of what follows; `false`: none");
  if (node && node->is_boolean()) {
    if (!node->as_boolean()->get()) patch.refinement = 1;
    return;
  }
  SceneTable table = body.table("patch");
  table.read("radius", patch.radius, inside(0, 1, "m"), "of the finer mesh where the tool is");
  if (!table.has("refinement")) patch.refinement = kByElements;
  table.read("refinement", patch.refinement, within(1, 4),
             {"edges are cut into so many parts; 1 = none",
              "2; 1 for quadratic elements with edges below half of `radius`, whose nodes lie close enough"});
  table.read("hysteresis", patch.hysteresis, within(0, 1),
             "of the radius: how far a touch moves before the patch follows");
  table.finish();
}

void read_cache(SceneTable& body, SfemScene& scene) {
  const toml::node* node = body.find("cache");
  body.describe("cache", "", "the user's cache folder",
                "a folder in which Green's functions are kept between runs; `false`: not kept");
  if (node && node->is_boolean())
    scene.cached = node->as_boolean()->get();
  else
    body.read_path("cache", scene.cache,
                   {"a folder in which Green's functions are kept between runs; `false`: not kept",
                    "the user's cache folder"});
}

}  // namespace

SfemScene read_sfem_scene(SceneTable body, const std::string& name, Device device) {
  SfemScene scene;
  scene.device = device;
  body.begin_group("sfem");
  scene.name = name, scene.place = body.place();
  SceneLabels labels = scene_labels(body);
  scene.source = read_source(body, labels);
  read_material(body, scene.material);
  scene.inside = read_inside(body, scene.material, labels);
  if (auto* organ = std::get_if<LabeledOrgan>(&scene.source)) organ->label_note = labels.note;
  scene.inclusions = read_inclusions(body, scene.material);
  scene.fixed = read_held(body);
  read_elements(body, scene);
  body.read_choice<sfem::Formulation>(
      "formulation", scene.formulation,
      {{"standard", sfem::Formulation::kStandard}, {"averaged", sfem::Formulation::kAveraged}},
      "`\"averaged\"`: volumes are averaged around nodes, so that tissue near ν = 0.5 does not lock");
  body.read_choice<sfem::Precision>(
      "precision", scene.precision,
      {{"single", sfem::Precision::kSingle}, {"double", sfem::Precision::kDouble}},
      "of the stored Green's functions; or `\"double\"`");
  read_patch(body, scene.patch);
  SceneTable viscosity = body.table("viscosity");
  viscosity.read("ratio", scene.viscosity, within(0, 100), "a sudden press is 1 + ratio times as stiff");
  viscosity.read("time", scene.viscous_time, inside(0, 1000, "s"), "in which that relaxes");
  viscosity.finish();
  body.read("rotations", scene.rotations,
            "take large rotations out of the strain, so that a deep press does not swell");
  body.read(
      "memory", scene.memory, within(0.001, 1024, "GB"),
      "for Green's functions; when they need more, columns are computed where the tools are. A patch may "
      "take as much while it is built (0.25 GB always): beyond it a scene is refused before anything is "
      "spent, and a patch that would follow the tools is not built: the one before stays, which is reported");
  body.read("contacts", scene.contacts, within(8, 512),
            "places that a tick solves for, of all tools together. A tool that touches more points than that "
            "is felt through clusters of them, which costs accuracy (a few percent) and no time; more places "
            "cost time, with their number cubed");
  read_cache(body, scene);
  body.read_path("seen", scene.seen,
                 "a finer surface that moves with the body and is drawn instead (OBJ, STL, PLY, VTP, VTK)");
  body.read("seen_scale", scene.seen_scale, kScale, "metres a unit of it");
  scene.seen_up = up_of(scene.source);  // of one organ, most likely from one program
  read_up(body, "seen_up", scene.seen_up);
  body.finish();
  return scene;
}

}  // namespace turgor

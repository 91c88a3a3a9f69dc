#include "turgor/sim/live/change_world.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/build/change_fabric.hpp"
#include "turgor/models/cloth/build/scale_stiffness.hpp"
#include "turgor/models/lattice/build/change_tissue.hpp"
#include "turgor/models/lattice/build/fiber_lines.hpp"
#include "turgor/models/lattice/build/scale_stiffness.hpp"
#include "turgor/models/lattice/build/skin.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/sim/bodies/cloth/upload_cloth.hpp"
#include "turgor/sim/bodies/lattice/upload_lattice.hpp"
#include "turgor/sim/scene/scene_cells.hpp"

namespace turgor {

namespace {

/// Group and key, as in SceneKey.
constexpr std::string_view kLive[][2] = {
    {"world", "gravity"},
    {"lattice", "gravity"},
    {"lattice", "solver.sweeps"},
    {"lattice", "solver.damping"},
    {"lattice", "skin.tension"},
    {"lattice", "skin.stiffness"},
    {"lattice", "skin.shear"},
    {"lattice", "skin.amplification"},
    {"lattice", "skin.stiffening"},
    {"lattice", "skin.fiber_stiffness"},
    {"lattice", "skin.fiber_stiffening"},
    {"lattice", "skin.dispersion"},
    {"cloth", "wind.velocity"},
    {"cloth", "wind.density"},
    {"cloth", "wind.pressure"},
    {"cloth", "wind.drag"},
    {"cloth", "wind.gusts"},
    {"cloth", "wind.gust_length"},
    {"cloth", "solver.sweeps"},
    {"cloth", "solver.strain_limit"},
    {"cloth", "damping.motion"},
    {"cloth", "damping.stretch"},
    {"cloth", "collision.friction"},
    {"sfem", "young"},
    {"sfem", "stiffening"},
    {"lattice", "tissue.young"},
    {"lattice", "tissue.gas"},
    {"lattice", "tissue.fat"},
    {"lattice", "tissue.muscle"},
    {"lattice", "tissue.bone"},
    {"lattice", "tissue.poisson"},
    {"lattice", "tissue.volume"},
    {"lattice", "tissue.stiffening"},
    {"lattice", "tissue.alpha"},
    {"cloth", "fabric.density"},
    {"cloth", "fabric.warp"},
    {"cloth", "fabric.weft"},
    {"cloth", "fabric.shear"},
    {"cloth", "fabric.poisson"},
    {"cloth", "fabric.rigidity_warp"},
    {"cloth", "fabric.rigidity_weft"},
    {"tool", "friction"},
};

/// Keys of bodies of every model that has them.
constexpr std::string_view kLiveOfAll[] = {"stiffness_scale", "texture.roughness", "texture.wavelength"};

/// The same for all keys that begin so, unless they are listed below as an exception.
constexpr std::string_view kLiveFamilies[][2] = {
    {"lattice", "tissue.fiber."}, {"lattice", "tissue.labels."}, {"lattice", "layers."},
    {"lattice", "viscosity."},    {"lattice", "permanent_set."}, {"sfem", "viscosity."},
    {"rhombus", "viscosity."},
};
constexpr std::string_view kNotLive[][2] = {
    {"lattice", "layers.name"},
    {"lattice", "layers.label"},
    {"lattice", "layers.hu"},
    {"lattice", "layers.tissue"},
    {"lattice", "layers.toughness"},
    {"lattice", "layers.color"},
    {"lattice", "tissue.fiber.direction_field"},
};

/// Reason for keys that need a reload; the first matching prefix applies.
struct ReloadReason {
  std::string_view group, prefix, why;
};
constexpr ReloadReason kReloadReasons[] = {
    {"sfem", "inside.", "Green's functions depend on its ratio to the surrounding material"},
    {"sfem", "inclusion.", "Green's functions depend on its ratio to the surrounding material"},
    {"sfem", "patch.", "the present patch was built with it"},
    {"sfem", "", "the mesh and its Green's functions depend on it"},
    {"rhombus", "", "the chains of the surface depend on it"},
    {"lattice", "tissue.", "the elements of the lattice depend on it"},
    {"lattice", "layers.toughness", "needles read it when they begin"},
    {"lattice", "layers.color", "labels of colored layers are kept from the loading on"},
    {"lattice", "layers.", "the regions of the lattice depend on it"},
    {"lattice", "", "the lattice depends on it"},
    {"rigid", "", "the mass and the motion of the rigid body depend on it"},
    {"cloth", "fabric.", "the fabric's springs depend on it"},
    {"cloth", "", "the cloth depends on it"},
    {"tool", "", "the tool's shape and path were set on the body at rest"},
    {"incision", "", "the blade was tested on the body at rest"},
    {"excision", "", "the blade was tested on the body at rest"},
    {"suture", "", "the stitches were tested on the body at rest"},
    {"world", "", "frames and haptic ticks depend on it"},
};

template <class Bodies>
const auto* find_named(const Bodies& bodies, const SceneKey& key) {
  const auto found = std::find_if(bodies.begin(), bodies.end(), [&key](const auto& body) {
    return key.path.starts_with(key.group == "tool" ? "tool." + body.name + "." : "body." + body.name + ".");
  });
  return found == bodies.end() ? nullptr : &*found;
}

/// A model without an overload below has no parameters that change while it runs.
template <class BodyScene, class Body>
void change_body(const Exec&, const BodyScene&, Body&) {}

/// Reason why the laws of a lattice cannot change while it runs; null if they can.
const char* why_fixed_laws(const LatticeScene& scene) {
  return scene.params.solver.method == lattice::Method::kPbd ? "projections have no moduli" : nullptr;
}

/// Gives a lattice the laws of the scene. False if they are the same, or cannot change.
bool change_laws(const Exec& exec, const LatticeScene& scene, LatticeBody& body) {
  if (why_fixed_laws(scene)) return false;
  const lattice::TissueParams tissue = lattice::reachable_tissue(scene.params.tissue, body.model);
  if (tissue == body.model.params.tissue) return false;
  lattice::change_tissue(exec, tissue, scene.stiffness_scale, body.model, body.state.change());
  lattice::set_fiber_lines(body.fiber_lines, body.model);
  return true;
}

/// Layers by depth resist needles down to their present depths.
void change_needle_layers(const LatticeScene& scene, std::vector<NeedleLayerScene>& layers) {
  if (scene.inside.size() != layers.size()) return;  // a toughness that waits for a restart
  for (std::size_t n = 0; n < layers.size(); n++)
    if (layers[n].is_of_layers) layers[n].depth = scene.inside[n].depth;
}

void change_body(const Exec& exec, const LatticeScene& scene, LatticeBody& body) {
  lattice::Params& params = body.model.params;
  const lattice::SkinParams skin = params.skin;
  const bool is_same_motion = body.has_gravity == scene.has_gravity &&
                              params.solver.sweeps == scene.params.solver.sweeps &&
                              params.solver.damping == scene.params.solver.damping;
  body.has_gravity = scene.has_gravity;
  params.solver.sweeps = scene.params.solver.sweeps;
  params.solver.damping = scene.params.solver.damping;
  params.skin.tension_along = scene.params.skin.tension_along;
  params.skin.tension_across = scene.params.skin.tension_across;
  params.skin.stiffness = scene.params.skin.stiffness;
  params.skin.shear = scene.params.skin.shear;
  params.skin.amplification = scene.params.skin.amplification;
  params.skin.stiffening = scene.params.skin.stiffening;
  params.skin.fiber_stiffness = scene.params.skin.fiber_stiffness;
  params.skin.fiber_stiffening = scene.params.skin.fiber_stiffening;
  params.skin.dispersion = scene.params.skin.dispersion;
  change_needle_layers(scene, body.layers.layers);
  bool has_changed = change_laws(exec, scene, body);
  if (has_changed) body.stiffness_scale = scene.stiffness_scale;
  if (params.skin != skin && !body.model.prestress_force.empty()) {
    body.model.prestress_force = lattice::measure_prestress(exec, body.model);
    body.state.renew_prestress(body.model);
  }
  if (!is_same_motion || params.skin != skin) body.state.wake();
  if (scene.stiffness_scale != body.stiffness_scale) {
    lattice::scale_stiffness(scene.stiffness_scale / body.stiffness_scale, body.model, body.state.change());
    body.stiffness_scale = scene.stiffness_scale, has_changed = true;
  }
  if (has_changed && body.state.has_device()) upload_changed_model(body);
}

void change_wind(const ClothScene& before, const ClothScene& scene, ClothBody& body) {
  if (before.air != scene.air || before.turns != scene.turns) body.air = scene.air, body.turns = scene.turns;
}

/// Fabric of a built cloth with the values of `wanted` that change while it moves.
cloth::Fabric live_fabric(const cloth::Fabric& wanted, cloth::Fabric own) {
  own.density = wanted.density, own.warp = wanted.warp, own.weft = wanted.weft, own.shear = wanted.shear;
  own.poisson = wanted.poisson;
  own.rigidity_warp = wanted.rigidity_warp, own.rigidity_weft = wanted.rigidity_weft;
  return own;
}

void change_body(const Exec& exec, const ClothScene& scene, ClothBody& body) {
  cloth::Params& params = body.model.params;
  params.damping = scene.params.damping;
  params.solver.sweeps = scene.params.solver.sweeps;
  params.solver.strain_limit = scene.params.solver.strain_limit;
  params.collision.friction = scene.params.collision.friction;
  const cloth::Fabric fabric = live_fabric(scene.params.fabric, body.fabric);
  if (fabric != body.fabric) {
    if (!cloth::change_fabric(exec, fabric, body.triangles, body.model, body.state.change())) return;
    body.fabric = fabric, body.stiffness_scale = 1;
  } else if (scene.stiffness_scale == body.stiffness_scale) {
    return;
  }
  if (scene.stiffness_scale != body.stiffness_scale)
    cloth::scale_stiffness(scene.stiffness_scale / body.stiffness_scale, body.model);
  body.stiffness_scale = scene.stiffness_scale;
  if (body.state.has_device()) upload_changed_model(body);
}

/// All forces of a linear body scale with its stiffness; the shape under a given press stays. Ticks get the
/// viscosity and the exponent of the law with the next frame.
void change_body(const Exec&, const SfemScene& scene, SfemBody& body) {
  if (!body.law && !body.needles.inner) body.viscosity = scene.viscosity;  // else it waits
  if (body.law && scene.law && body.law->stiffening != scene.law->stiffening)
    body.law = scene.law, body.law_forces.clear();  // the next solution has the law, also for the same forces
  TURGOR_CHECK(!body.model.body.materials.empty(), "a body has a material");
  const double young = body.model.body.materials[0].young;  // of the loaded body
  const bool has_one_material = scene.inside.empty() && scene.inclusions.empty();
  body.stiffness_scale = scene.stiffness_scale * (has_one_material ? scene.material.young / young : 1);
}

/// Ticks get stiffness and viscosity with the next frame.
void change_body(const Exec&, const RhombusScene& scene, RhombusBody& body) {
  body.stiffness_scale = scene.stiffness_scale, body.viscosity = scene.params.viscosity;
}

void change_tools(const Scene& scene, World& world) {
  for_each_touched(world, [&](BodyId, auto& body) {
    for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
      const auto tool = std::size_t(body.tool_indices[t]);
      if (tool < scene.tools.size()) set_friction(body, t, scene.tools[tool].friction);
    }
  });
}

template <std::size_t kCount>
bool is_among(const std::string_view (&keys)[kCount][2], const SceneKey& key) {
  return std::any_of(std::begin(keys), std::end(keys),
                     [&key](const auto& one) { return key.group == one[0] && key.key == one[1]; });
}
bool is_live(const SceneKey& key) {
  if (key.path.starts_with("body.") &&
      std::find(std::begin(kLiveOfAll), std::end(kLiveOfAll), key.key) != std::end(kLiveOfAll))
    return true;
  const auto begins = [&key](const auto& one) { return key.group == one[0] && key.key.starts_with(one[1]); };
  return is_among(kLive, key) || (std::any_of(std::begin(kLiveFamilies), std::end(kLiveFamilies), begins) &&
                                  !is_among(kNotLive, key));
}
/// True for the live keys of the laws of a lattice.
bool is_live_law(const SceneKey& key) {
  return is_live(key) && (key.key.starts_with("tissue.") || key.key.starts_with("layers.") ||
                          key.key.starts_with("viscosity.") || key.key.starts_with("permanent_set."));
}

/// Reason why the stiffness of a body cannot change in a running world; null if it can.
const char* why_not_scaled(const Scene& scene, const SceneKey& key) {
  const LatticeScene* lattice = key.group == "lattice" ? find_named(scene.lattice_bodies, key) : nullptr;
  return lattice ? why_fixed_laws(*lattice) : nullptr;
}

/// True if a needle enters the body of the key.
bool has_needle(const Scene& scene, const SceneKey& key) {
  return std::any_of(scene.tools.begin(), scene.tools.end(), [&](const ToolScene& tool) {
    return std::holds_alternative<NeedleTool>(tool.shape) && tool.body.kind == BodyKind::kSfem &&
           &scene.sfem_bodies[std::size_t(tool.body.index)] == find_named(scene.sfem_bodies, key);
  });
}

/// True if the skin of a lattice has another law than the one of this key.
bool is_of_other_skin(const Scene& scene, const SceneKey& key) {
  const LatticeScene* lattice = key.group == "lattice" ? find_named(scene.lattice_bodies, key) : nullptr;
  if (!lattice) return false;
  const bool exponential = lattice->params.skin.law == lattice::SkinLaw::kExponential;
  for (const std::string_view name : {"skin.stiffness", "skin.amplification"})
    if (key.key == name) return exponential;
  for (const std::string_view name :
       {"skin.stiffening", "skin.fiber_stiffness", "skin.fiber_stiffening", "skin.dispersion"})
    if (key.key == name) return !exponential;
  return false;
}

/// True if the fabric of a cloth has another law than the one of this key.
bool is_of_other_fabric(const Scene& scene, const SceneKey& key) {
  const ClothScene* cloth = key.group == "cloth" ? find_named(scene.cloth_bodies, key) : nullptr;
  if (!cloth || cloth->params.fabric.law == cloth::Law::kSheet) return false;
  return key.key == "fabric.poisson" || key.key.starts_with("fabric.rigidity_");
}

/// Energy of the layer in a path such as "body.arm.layers[1].young"; that of the body for other paths.
lattice::SolidEnergy energy_of_path(const lattice::TissueParams& tissue, std::string_view path) {
  constexpr std::string_view kLayers = ".layers[";
  const std::size_t at = path.find(kLayers);
  if (at == path.npos) return tissue.energy;
  std::size_t index = tissue.layers.size();
  std::from_chars(path.data() + at + kLayers.size(), path.data() + path.size(), index);
  return index < tissue.layers.size() ? energy_of(tissue.layers[index], tissue) : tissue.energy;
}

/// True if the tissue of a lattice, or the layer of the path, has another law than the one of this key.
bool is_of_other_law(const lattice::TissueParams& tissue, std::string_view key, std::string_view path) {
  using lattice::SolidEnergy, lattice::TissueLaw;
  if (tissue.law == TissueLaw::kSprings)
    return key == "tissue.poisson" || key.ends_with("stiffening") || key.ends_with("alpha") ||
           key.find("fiber.") != key.npos || key.starts_with("layers.") || key.starts_with("viscosity.") ||
           key.starts_with("permanent_set.");
  if (key == "tissue.volume") return true;
  const SolidEnergy energy = energy_of_path(tissue, path);
  if (key.ends_with("alpha")) return energy != SolidEnergy::kOgden;
  const bool exponential = key.ends_with("stiffening") || key.find("fiber.") != key.npos;
  return exponential && energy != SolidEnergy::kExponential;
}

/// True for keys of laws by cell that a solid body can get, which partial cells and the GPU do not support.
bool needs_whole_cells(std::string_view key) {
  return key.starts_with("viscosity.") || key.starts_with("permanent_set.");
}

/// Reason why a law's key of a lattice cannot change in a running world; null if it can, and for other keys.
const char* why_not_of_law(const Scene& scene, const SceneKey& key) {
  const LatticeScene* lattice = key.group == "lattice" ? find_named(scene.lattice_bodies, key) : nullptr;
  if (!lattice || !is_live_law(key)) return nullptr;
  if (key.key.starts_with("layers.") && key.path.find("layers[") == key.path.npos)
    return "the body has no layers";
  if (is_of_other_law(lattice->params.tissue, key.key, key.path)) return "the tissue has another law";
  if (lattice->params.tissue.partial_cells && needs_whole_cells(key.key))
    return "partial cells do not relax (tissue.partial_cells = false)";
  if (lattice->device == Device::kGpu && needs_whole_cells(key.key)) return "tissue on a GPU does not relax";
  return why_fixed_laws(*lattice);
}

}  // namespace

std::string why_not_live(const Scene& scene, const SceneKey& key) {
  const SfemScene* sfem = key.group == "sfem" ? find_named(scene.sfem_bodies, key) : nullptr;
  if (sfem && key.key == "young" && !(sfem->inside.empty() && sfem->inclusions.empty()))
    return "Green's functions depend on the ratio of its materials";
  if (sfem && key.key == "stiffening" && !(sfem->law && sfem->law->stiffening > 0))
    return "only law = \"exponential\" has an exponent";
  if (sfem && key.key.starts_with("viscosity.")) {
    if (sfem->law) return "a nonlinear patch does not relax";
    if (has_needle(scene, key)) return "needles need an elastic body";
  }
  if (key.key == "stiffness_scale" && why_not_scaled(scene, key)) return why_not_scaled(scene, key);
  if (is_of_other_skin(scene, key)) return "the skin has another law";
  if (is_of_other_fabric(scene, key)) return "the fabric has another law";
  if (const char* why = why_not_of_law(scene, key)) return why;
  const ToolScene* tool = key.group == "tool" ? find_named(scene.tools, key) : nullptr;
  if (tool && key.key == "friction" && tool->body.kind == BodyKind::kRhombus)
    return "chains have no friction";
  if (is_live(key)) return {};
  for (const ReloadReason& made : kReloadReasons)
    if (key.group == made.group && key.key.starts_with(made.prefix)) return std::string(made.why);
  return "the world depends on it";
}

std::optional<std::string> override_of(const std::vector<std::string>& overrides, const std::string& key) {
  for (auto one = overrides.rbegin(); one != overrides.rend(); ++one)
    if (one->starts_with(key + "=")) return one->substr(key.size() + 1);
  return std::nullopt;
}

Result<Scene> with_change(const Scene& scene, const std::string& key,
                          const std::optional<std::string>& value) {
  std::vector<std::string> overrides = scene.overrides;
  const std::string prefix = key + "=";
  std::erase_if(overrides, [&prefix](const std::string& one) { return one.starts_with(prefix); });
  if (value) overrides.push_back(prefix + *value);
  Result<Scene> changed = parse_scene(scene.text, scene.file, overrides);
  if (changed && scene.has_whole_cells) use_whole_cells(*changed);
  return changed;
}

void change_world(const Exec& exec, const Scene& before, const Scene& scene, World& world) {
  TURGOR_CHECK(world.cloth_bodies.size() == scene.cloth_bodies.size() &&
                   before.cloth_bodies.size() == scene.cloth_bodies.size(),
               "a changed scene has the bodies of its world");
  world.gravity = scene.gravity;
  for_each_kind(scene, world, [&exec](BodyKind, const auto& scenes, auto& bodies) {
    TURGOR_CHECK(scenes.size() == bodies.size(), "a changed scene has the bodies of its world");
    for (std::size_t b = 0; b < bodies.size(); b++) {
      change_body(exec, scenes[b], bodies[b]);
      if constexpr (is_touched<decltype(bodies[b])>)
        bodies[b].texture.waves = scenes[b].texture.waves;  // ticks get them with the next frame
    }
  });
  for (std::size_t b = 0; b < world.cloth_bodies.size(); b++)
    change_wind(before.cloth_bodies[b], scene.cloth_bodies[b], world.cloth_bodies[b]);
  change_tools(scene, world);
}

}  // namespace turgor

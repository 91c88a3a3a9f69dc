#include "turgor/sim/live/change_world.hpp"

#include <algorithm>
#include <string_view>

#include "turgor/models/lattice/build/skin.hpp"

namespace turgor {

namespace {

/// As SceneKey lists them: group and key.
constexpr std::string_view kLive[][2] = {
    {"world", "gravity"},
    {"lattice", "gravity"},
    {"lattice", "solver.sweeps"},
    {"lattice", "solver.damping"},
    {"lattice", "skin.tension"},
    {"lattice", "skin.stiffness"},
    {"lattice", "skin.shear"},
    {"lattice", "skin.amplification"},
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
    {"tool", "friction"},
};

/// What is made of a key, and stays as it was made; the first that fits.
struct Made {
  std::string_view group, prefix, why;
};
constexpr Made kMade[] = {
    {"sfem", "inside.", "Green's functions are made for its ratio to what is around it"},
    {"sfem", "inclusion.", "Green's functions are made for its ratio to what is around it"},
    {"sfem", "patch.", "the next patch could be made with it, the present one cannot"},
    {"sfem", "viscosity.", "what the tissue remembers was felt with it"},
    {"sfem", "", "the mesh and its Green's functions are made of it"},
    {"rhombus", "", "the chains of the surface are made of it"},
    {"lattice", "tissue.", "the springs of the lattice are made of it"},
    {"lattice", "", "the lattice is made of it"},
    {"cloth", "fabric.", "the fabric's springs are made of it"},
    {"cloth", "", "the cloth is made of it"},
    {"tool", "", "the tool's shape and path are laid on the body at rest"},
    {"incision", "", "the blade was tried on the body at rest"},
    {"world", "", "frames and haptic ticks are counted by it"},
};

template <class Bodies>
const auto* find_named(const Bodies& bodies, const SceneKey& key) {
  const auto found = std::find_if(bodies.begin(), bodies.end(), [&key](const auto& body) {
    return key.path.starts_with(key.group == "tool" ? "tool." + body.name + "." : "body." + body.name + ".");
  });
  return found == bodies.end() ? nullptr : &*found;
}

void change_body(const Exec& exec, const LatticeScene& scene, LatticeBody& body) {
  body.has_gravity = scene.has_gravity;
  lattice::Params& params = body.model.params;
  params.solver.sweeps = scene.params.solver.sweeps;
  params.solver.damping = scene.params.solver.damping;
  params.skin.tension_along = scene.params.skin.tension_along;
  params.skin.tension_across = scene.params.skin.tension_across;
  params.skin.stiffness = scene.params.skin.stiffness;
  params.skin.shear = scene.params.skin.shear;
  params.skin.amplification = scene.params.skin.amplification;
  const bool has_pull = !body.model.skin.pull.empty();
  if (has_pull) lattice::measure_pull(exec, body.model, body.model.skin);
  body.state.change().sleep = {};  // all rows feel it
}

void change_wind(const ClothScene& before, const ClothScene& scene, ClothBody& body) {
  if (before.air != scene.air || before.turns != scene.turns) body.air = scene.air, body.turns = scene.turns;
}

void change_body(const Exec&, const ClothScene& scene, ClothBody& body) {
  cloth::Params& params = body.model.params;
  params.damping = scene.params.damping;
  params.solver.sweeps = scene.params.solver.sweeps;
  params.solver.strain_limit = scene.params.solver.strain_limit;
  params.collision.friction = scene.params.collision.friction;
}

/// All forces of a linear body are as many times as large; pressed as far, it lies as it did.
void change_body(const Exec&, const SfemScene& scene, SfemBody& body) {
  body.stiffer = scene.material.young / body.model.body.materials[0].young;
}

void change_tools(const Scene& scene, World& world) {
  for_each_touched(world, [&](BodyId, auto& body) {
    for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
      const auto tool = std::size_t(body.tool_indices[t]);
      if (tool < scene.tools.size()) set_friction(body, t, scene.tools[tool].friction);
    }
  });
}

/// What else is ticked by a haptic thread stays as it was made.
template <class BodyScene, class Body>
void change_body(const Exec&, const BodyScene&, Body&) {}

}  // namespace

std::string why_not_live(const Scene& scene, const SceneKey& key) {
  const SfemScene* sfem = key.group == "sfem" ? find_named(scene.sfem_bodies, key) : nullptr;
  if (sfem && key.key == "young" && !(sfem->inside.empty() && sfem->inclusions.empty()))
    return "Green's functions are made for the ratio of its parts";
  const ToolScene* tool = key.group == "tool" ? find_named(scene.tools, key) : nullptr;
  if (tool && key.key == "friction" && tool->body.kind == BodyKind::kRhombus)
    return "chains know no friction";
  if (std::any_of(std::begin(kLive), std::end(kLive),
                  [&key](const auto& live) { return key.group == live[0] && key.key == live[1]; }))
    return {};
  for (const Made& made : kMade)
    if (key.group == made.group && key.key.starts_with(made.prefix)) return std::string(made.why);
  return "the world is made of it";
}

Result<Scene> with_change(const Scene& scene, const std::string& key, const std::string& value) {
  std::vector<std::string> overrides = scene.overrides;
  const std::string prefix = key + "=";
  std::erase_if(overrides, [&prefix](const std::string& one) { return one.starts_with(prefix); });
  overrides.push_back(prefix + value);
  return parse_scene(scene.text, scene.file, overrides);
}

void change_world(const Exec& exec, const Scene& before, const Scene& scene, World& world) {
  world.gravity = scene.gravity;
  for_each_kind(scene, world, [&exec](BodyKind, const auto& scenes, auto& bodies) {
    for (std::size_t b = 0; b < bodies.size(); b++) change_body(exec, scenes[b], bodies[b]);
  });
  for (std::size_t b = 0; b < world.cloth_bodies.size(); b++)
    change_wind(before.cloth_bodies[b], scene.cloth_bodies[b], world.cloth_bodies[b]);
  change_tools(scene, world);
}

}  // namespace turgor

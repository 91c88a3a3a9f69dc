#include "turgor/sim/live/change_world.hpp"

#include <algorithm>
#include <string_view>

#include "turgor/models/lattice/skin.hpp"

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
};

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
  body.state.sleep = {};  // all rows feel it
}

void change_body(const Exec&, const ClothScene& scene, ClothBody& body) {
  body.air = scene.air, body.turns = scene.turns;
  cloth::Params& params = body.model.params;
  params.damping = scene.params.damping;
  params.solver.sweeps = scene.params.solver.sweeps;
  params.solver.strain_limit = scene.params.solver.strain_limit;
  params.collision.friction = scene.params.collision.friction;
}

/// What haptic threads tick stays as it was made.
template <class BodyScene, class Body>
void change_body(const Exec&, const BodyScene&, Body&) {}

}  // namespace

bool changes_live(const SceneKey& key) {
  return std::any_of(std::begin(kLive), std::end(kLive),
                     [&key](const auto& live) { return key.group == live[0] && key.key == live[1]; });
}

void change_world(const Exec& exec, const Scene& scene, World& world) {
  world.gravity = scene.gravity;
  for_each_kind(scene, world, [&exec](BodyKind, const auto& scenes, auto& bodies) {
    for (std::size_t b = 0; b < bodies.size(); b++) change_body(exec, scenes[b], bodies[b]);
  });
}

}  // namespace turgor

#include "turgor/sim/world.hpp"

#include <algorithm>
#include <array>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/bodies/cloth/free_support.hpp"
#include "turgor/sim/replace_cuts.hpp"
#include "turgor/sim/tools/load_texture.hpp"
#include "turgor/sim/tools/load_tool.hpp"

namespace turgor {

namespace {

/// Loads the texture of a touched body.
template <class BodyScene, class Body>
Status load_texture_of(const BodyScene& scene, Body& body) {
  if constexpr (is_touched<Body>) {
    Result<contact::Texture> texture = load_texture(scene.texture);
    if (!texture) return texture.error();
    body.texture = std::move(*texture);
  }
  return Done{};
}

Status load_bodies(const Loading& loading, const Scene& scene, World& world) {
  Status status = Done{};
  for_each_kind(scene, world, [&](BodyKind, const auto& scenes, auto& bodies) {
    for (const auto& body_scene : scenes) {
      if (!status) return;
      auto body = load_body(loading, body_scene, world);
      if (!body) status = body.error();
      if (status && loading.purpose == Purpose::kSimulate) status = load_texture_of(body_scene, *body);
      if (status) bodies.push_back(std::move(*body));
    }
  });
  return status;
}

Result<TouchingTool> make_tool(const Loading& loading, const ToolScene& scene, World& world) {
  if (loading.purpose == Purpose::kDraw) return load_tool_shape(scene);
  visit_body(world, scene.body, [&loading](auto& body) {
    if constexpr (is_touched<decltype(body)>) make_rest_surface(loading.exec, body);
  });
  return load_tool(scene, touched_body(world, scene.body).name, rest_surface(world, scene.body));
}

Status load_tools(const Loading& loading, const Scene& scene, World& world) {
  for (const ToolScene& tool_scene : scene.tools) {
    Result<TouchingTool> tool = make_tool(loading, tool_scene, world);
    if (!tool) return tool.error();
    touched_body(world, tool_scene.body).tool_indices.push_back(int(world.tools.size()));
    world.tools.push_back(std::move(*tool));
  }
  return Done{};
}

/// Prepares a body for contact, after its tools were loaded.
Status begin_bodies(const Exec& exec, const Scene& scene, World& world) {
  Status status = Done{};
  for_each_kind(scene, world, [&](BodyKind, const auto& scenes, auto& bodies) {
    if constexpr (is_touched<decltype(bodies[0])>)
      for (std::size_t b = 0; b < bodies.size() && status; b++)
        status = begin_body(exec, bodies[b], scenes[b], world);
  });
  return status;
}

template <class AnyWorld>
auto* find_touched(AnyWorld& world, BodyId id) {
  using Found = std::conditional_t<std::is_const_v<AnyWorld>, const TouchedBody*, TouchedBody*>;
  const Found found = visit_body(world, id, [](auto& body) -> Found {
    if constexpr (is_touched<decltype(body)>) return &body;
    return nullptr;
  });
  TURGOR_ASSERT(found, "tools touch bodies of models that can be touched");
  return found;
}

/// Hash of all tool logs.
std::uint64_t hash_of(const std::vector<TouchingTool>& tools, std::uint64_t hash) {
  for (const TouchingTool& tool : tools)
    for (const ForceSample& s : tool.samples)
      hash = hash_bytes(&s.force, sizeof s.force, hash_bytes(&s.torque, sizeof s.torque, hash));
  return hash;
}

std::uint64_t joined(std::uint64_t hash, std::uint64_t other) {
  return hash_bytes(&other, sizeof other, hash);
}

}  // namespace

TouchedBody& touched_body(World& world, BodyId id) { return *find_touched(world, id); }
const TouchedBody& touched_body(const World& world, BodyId id) { return *find_touched(world, id); }

RestSurface rest_surface(const World& world, BodyId id) {
  return visit_body(world, id, [](const auto& body) -> RestSurface {
    if constexpr (is_touched<decltype(body)>) return rest_surface(body);
    return {};
  });
}

Result<World> load_world(const Exec& exec, const Scene& scene, const BeginWork& begin, Purpose purpose) {
  World world;
  world.gravity = scene.gravity;
  TURGOR_ASSERT(scene.frame_rate > 0, "a scene has a frame rate");
  world.dt = 1 / scene.frame_rate;
  world.scene_notes = scene.notes;
  const Loading loading{exec, begin, purpose};
  Status status = load_bodies(loading, scene, world);
  if (status) status = replace_cuts(scene, world);
  if (status && purpose == Purpose::kSimulate) status = load_coupling(exec, scene, world);
  if (status) status = load_tools(loading, scene, world);
  if (status && purpose == Purpose::kSimulate) status = begin_bodies(exec, scene, world);
  if (status && purpose == Purpose::kSimulate) begin_coupling(exec, world);
  if (!status) return status.error();
  return world;
}

std::vector<std::string> notes_of(const World& world) {
  std::vector<std::string> sentences = world.scene_notes;
  for_each_body(world, [&](BodyId, const auto& body) {
    for (const std::string& note : notes(body)) sentences.push_back(body.name + ": " + note);
  });
  return sentences;
}

Result<FrameReport> step(const Exec& exec, World& world, bool measure_residual) {
  const Timer timer;
  FrameReport report;
  TURGOR_CHECK(is_step_length(world.dt), "a frame has a positive length");
  // advance the blades to the end of the frame
  const double from = time_of(world);
  for (std::size_t c = 0; c < world.cuts.size(); c++) {
    Cut& cut = world.cuts[c];
    const double end = (world.frame + 1) * world.dt * (1 + 1e-12);
    LatticeBody& body = world.lattice_bodies[std::size_t(cut.body)];
    TURGOR_CHECK(is_index(cut.body, world.lattice_bodies.size()), "a cut belongs to a lattice");
    if (const Status status = advance_blade(exec, body, world.cuts, int(c), end); !status)
      return status.error();
  }
  // pull the stitches
  for (Suture& suture : world.sutures) {
    const LatticeBody& body = world.lattice_bodies[std::size_t(suture.scene.body)];
    const Cut& cut = world.cuts[std::size_t(suture.scene.incision)];
    if (const Status status = advance_suture(body, cut, from + world.dt, suture); !status)
      return status.error();
  }
  // step all bodies
  const FrameInput input{from, from + world.dt, measure_residual};
  for_each_body(world, [&](BodyId, auto& body) { step_body(exec, body, world, input, report); });
  // apply cloth forces to the touched bodies, to supports together with those of the coupling
  const auto press = [&](bool is_support_kind) {
    for_each_touched(world, [&](BodyId id, auto& body) {
      if (is_support_kind == (id.kind == BodyKind::kLattice || id.kind == BodyKind::kRhombus))
        relax_free_loads(world, id), press_body(exec, body, cloth_forces_on(world, id), world.dt);
    });
  };
  press(false);
  couple_bodies(exec, world);
  press(true);
  // close the frame
  world.frame++;
  report.seconds = timer.seconds();
  return report;
}

std::uint64_t state_hash(const World& world) {
  std::array<std::uint64_t, kModelCount> of_kind;
  of_kind.fill(kHashSeed);
  for_each_body(world, [&](BodyId id, const auto& body) {
    std::uint64_t& hash = of_kind[std::size_t(id.kind)];
    hash = state_hash(body, hash);
  });
  // A single lattice has the hash of its model, into which the rest is combined. The order is that of the
  // first reports, so that hashes stay comparable.
  const auto kind = [&](BodyKind k) { return of_kind[std::size_t(k)]; };
  const bool touched = !world.sfem_bodies.empty() || !world.tools.empty();
  std::uint64_t hash = kind(BodyKind::kLattice);
  if (world.lattice_bodies.size() == 1 && world.rhombus_bodies.empty() && !touched)
    hash = lattice::state_hash(world.lattice_bodies[0].model, world.lattice_bodies[0].state);
  if (!world.rhombus_bodies.empty()) hash = joined(kind(BodyKind::kRhombus), hash);
  if (touched) hash = joined(hash, hash_of(world.tools, kind(BodyKind::kSfem)));
  for (const ClothBody& body : world.cloth_bodies) hash = state_hash(body, hash);
  for (std::size_t k = std::size_t(BodyKind::kCloth) + 1; k < kModelCount; k++)
    if (of_kind[k] != kHashSeed) hash = joined(hash, of_kind[k]);
  if (!is_empty(world.coupling)) hash = state_hash(world.coupling, hash);
  return hash;
}

}  // namespace turgor

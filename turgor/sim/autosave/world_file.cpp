#include "turgor/sim/autosave/world_file.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/surface/surface_plan.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/sim/autosave/transfer_snapshot.hpp"
#include "turgor/sim/bodies/sfem/needle_sfem.hpp"

namespace turgor {

namespace {

using SharedPatch = std::shared_ptr<const sfem::Patch>;

/// A state file with the patches that it refers to: those of the loaded world, then those stored in it.
template <class Stream>
struct WorldFile {
  static constexpr bool kReads = Stream::kReads;

  Stream& stream;
  std::vector<SharedPatch> patches;

  void bytes(void* data, std::size_t size) { stream.bytes(data, size); }
  void number(std::uint64_t value) { stream.number(value); }
  std::size_t count(std::size_t size) { return stream.count(size); }
  void fail() { stream.fail(); }
};

/// A patch is stored where it is met first, and as its number afterwards.
template <class File>
void transfer(File& file, SharedPatch& patch) {
  std::vector<SharedPatch>& known = file.patches;
  constexpr std::uint64_t kNone = std::uint64_t(-1);
  const auto found = patch ? std::find(known.begin(), known.end(), patch) : known.end();
  std::uint64_t number = patch ? std::uint64_t(found - known.begin()) : kNone;
  transfer(file, number);
  if constexpr (File::kReads) {
    patch.reset();
    if (number == kNone) return;
    if (number > known.size()) return file.fail();
    if (number < known.size()) {
      patch = known[number];
      if (!patch) file.fail();
      return;
    }
    const auto read = std::make_shared<sfem::Patch>();
    transfer(file, *read);
    known.push_back(patch = read);
  } else if (patch && found == known.end()) {
    transfer(file, const_cast<sfem::Patch&>(*patch));  // a writer changes nothing
    known.push_back(patch);
  }
}

template <class File>
void transfer(File& file, ClothLoad& load) {
  auto& [force, relaxation, compliance, next_axis] = load;
  transfer_all(file, force, relaxation, compliance, next_axis);
}
/// Without the shapes of the tools, the exponent of the law and the texture, which the scene gives, and
/// without values of a tick.
template <class File>
void transfer(File& file, contact::SfemTouch& touch) {
  auto& [patch, tools, follow, stiffness_scale, state, free, patch_number, solution_tick, motion_number,
         ticks, handover, poses, forces, needles, stiffening, texture, textures, tools_before, free_step] =
      touch;
  transfer_all(file, patch, follow, stiffness_scale, state, free, patch_number, solution_tick, motion_number,
               ticks, handover, poses, forces, needles, textures);
}
template <class File>
void transfer(File& file, contact::SfemTouchSnapshot& now) {
  auto& [patch, patch_number, ticks, force_jump, x, force, history, stiffening, stiffness_scale, poses,
         forces, centers, inner, needle_forces, track_elements, textures] = now;
  transfer_all(file, patch, patch_number, ticks, force_jump, x, force, history, stiffening, stiffness_scale,
               poses, forces, centers, needle_forces, track_elements, textures);
}
/// Without the stiffness matrices of the loaded body.
template <class File>
void transfer(File& file, Turning& turning) {
  auto& [corotation, state, frames, unconverged, largest_residual] = turning;
  transfer_all(file, state, frames, unconverged, largest_residual);
}
template <class File>
void transfer(File& file, ClothPress& press) {
  auto& [load, displacement] = press;
  transfer_all(file, load, displacement);
}
template <class File>
void transfer(File& file, CouplingLoad& load) {
  auto& [force, displacement] = load;
  transfer_all(file, force, displacement);
}
template <class File>
void transfer(File& file, FreeFlight& flight) {
  auto& [u, v, displacement] = flight;
  transfer_all(file, u, v, displacement);
}
template <class File>
void transfer(File& file, FreeDisplacement& free) {
  auto& [before, now, number] = free;
  transfer_all(file, before, now, number);
}
/// Elements around needles, whose Green's functions are solved again if loading has solved others.
template <class File>
void transfer_inner(File& file, std::shared_ptr<const sfem::InnerGreen>& inner) {
  if (!inner) return;  // made by loading
  std::vector<int> elements = inner->elements;
  transfer(file, elements);
  if constexpr (File::kReads)
    if (elements != inner->elements)
      inner = std::make_shared<const sfem::InnerGreen>(sfem::InnerGreen{.elements = std::move(elements)});
}
/// Without the Green's functions.
template <class File>
void transfer(File& file, NeedleDisplacement& needles) {
  auto& [inner, in_use, displacement, by_tools, motion, target_motion] = needles;
  transfer_all(file, displacement, by_tools, motion, target_motion);
}
template <class File>
void transfer_body(File& file, SfemBody& body) {
  TURGOR_ASSERT(!body.haptic && (!body.worker || !body.worker->is_busy()),
                "a state is written between two frames without a haptic thread");
  if (body.turning) transfer(file, *body.turning);  // made by loading
  transfer_all(file, body.press, body.coupling, body.flight, body.free, body.needles, body.stiffness_scale,
               body.friction, body.refinement, body.radius_is_open, body.refinement_is_open, body.contacts,
               body.patch_memory, body.follow, body.centers, body.patches, body.now, body.touch,
               body.built_patches, body.patch_is_ready, body.rebuilds, body.rejected_patches,
               body.rejection_reason, body.law_forces, body.law_summary, body.surface_strain);
  transfer_inner(file, body.needles.inner);
  transfer_inner(file, body.touch.needles.inner);
  // the nonlinear patch is made again from the patch in use, with its displacement
  if (body.nonlinear) body.law_displacement = body.nonlinear->u;
  transfer(file, body.law_displacement);
  if constexpr (File::kReads) body.nonlinear.reset();  // that of another patch or displacement
}

template <class File>
void transfer_body(File& file, RhombusBody& body) {
  transfer_all(file, body.touch, body.now, body.state, body.cloth, body.pressed_volume, body.openings,
               body.jump, body.jump_at);
}

/// The coarse space is built again for its time step. It depends on nothing else but the model and the cuts;
/// with later cuts the next step builds another one.
template <class File>
void transfer_coarse_space(File& file, const lattice::Model& model, lattice::State& state) {
  std::shared_ptr<const lattice::CoarseSpace>& coarse = state.workspace.coarse;
  std::optional<std::pair<std::size_t, double>> built;
  if (coarse) built = {coarse->version, coarse->dt};
  transfer(file, built);
  if constexpr (File::kReads) {
    coarse.reset();
    if (!built) return;
    lattice::CoarseSpace space = *lattice::make_coarse_space(model, state, built->second);
    space.version = built->first;
    coarse = std::make_shared<const lattice::CoarseSpace>(std::move(space));
  }
}

/// Host state of a body for this direction.
template <class File, class DeviceState>
typename DeviceState::State& state_of_body(DeviceState& state) {
  if constexpr (File::kReads) return state.change();
  return const_cast<typename DeviceState::State&>(state.host());
}

template <class File>
void transfer_body(File& file, LatticeBody& body) {
  lattice::State& state = state_of_body<File>(body.state);
  transfer(file, state);
  transfer_coarse_space(file, body.model, state);
  transfer_all(file, body.textures, body.last_displacement, body.row_steps, body.row_steps_asleep, body.cloth,
               body.surface, body.rest, body.surface_cuts, body.touch, body.poses, body.forces,
               body.layers.before, body.layers.motion, body.needles);
  if constexpr (File::kReads)
    if (body.surface.fragments)
      body.surface.plan = lattice::detail::make_surface_plan(Exec(1), body.model, state.cuts, body.surface);
}

template <class File>
void transfer_body(File& file, ClothBody& body) {
  transfer(file, state_of_body<File>(body.state));
  transfer_all(file, body.textures, body.air.velocity, body.samples, body.poses, body.forces);
  for (ClothHold& hold : body.holds)
    transfer_all(file, hold.vertices, hold.positions, hold.is_held, hold.missed, hold.force);
  for (ClothObstacle& obstacle : body.obstacles) {
    transfer(file, obstacle.force);
    if (!obstacle.support) continue;
    auto& [body_id, carrier, triangles, positions, moving, force, pressing, wrench, relaxed] =
        *obstacle.support;
    transfer_all(file, positions, force, wrench, relaxed);
  }
}

/// Without the tool, which the scene gives.
template <class File>
void transfer(File& file, RigidTouch& touch) {
  auto& [tool, mesh, radius, pose, next, hold, grasped, sites, grasp, load, force] = touch;
  transfer_all(file, pose, next, hold, grasped, sites, grasp, load, force);
}
template <class File>
void transfer_body(File& file, RigidBody& body) {
  transfer_all(file, body.textures, body.state, body.next, body.samples, body.cloth, body.borne);
  for (RigidTouch& touch : body.touches) transfer(file, touch);
}

/// Log without samples that starts at the same pose.
TouchLog emptied(const TouchLog& log) {
  TouchLog empty;
  empty.start(command_of(log.start()));
  return empty;
}
/// Replaces the samples. The path of each is summed again while reading.
template <class File>
void transfer(File& file, TouchLog& log) {
  if constexpr (File::kReads) log = emptied(log);
  std::uint64_t count = log.size();
  transfer(file, count);
  for (std::uint64_t n = 0; n < count; n++) {
    ForceSample sample;
    if constexpr (!File::kReads) sample = log[n];
    transfer(file, sample);
    if constexpr (File::kReads) {
      if (!file.stream.is_sound()) return;
      log.append(sample);
    }
  }
}

template <class File>
void transfer(File& file, ToolPath& path) {
  auto& [rows, smooth] = path;
  transfer_all(file, rows, smooth);
}

/// Without what loading finds: bodies, areas and distances at rest.
template <class File>
void transfer(File& file, Attachment& attachment) {
  auto& [name, between, ties, area, stiffness, samples, torn_at, swept, ahead] = attachment;
  transfer_all(file, ties, samples, torn_at, ahead);
}
template <class File>
void transfer(File& file, BodyContact& contact) {
  // the unbalanced force is read in the frame that finds it
  auto& [name, between, body, ground, params, swept, rest_height, sites, samples, dropped_most, deepest,
         unbalanced] = contact;
  transfer_all(file, sites, samples, dropped_most, deepest);
}
template <class File>
void transfer_coupling(File& file, Coupling& coupling) {
  auto& [supports, attachments, contacts, frames, unsolved, storage] = coupling;
  for (CoupledSupport& support : supports)
    transfer_all(file, support.force, support.solved, support.stiffness);
  for (Attachment& attachment : attachments) transfer(file, attachment);
  for (BodyContact& contact : contacts) transfer(file, contact);
  transfer_all(file, frames, unsolved);
}

template <class File>
void transfer(File& file, lattice::Incision& blade) {
  auto& [name, from, to, path, depth, tilt, start, duration, width, through_bone, excision, undermine] =
      blade;
  transfer_all(file, name, from, to, path, depth, tilt, start, duration, width, through_bone, excision,
               undermine);
}
/// Without `before`: an undo needs the world as it was in memory.
template <class File>
void transfer(File& file, Cut& cut) {
  auto& [blade, body, path, done, edges, specimen, before] = cut;
  transfer_all(file, blade, body, path, done, edges, specimen);
}
template <class File>
void transfer(File& file, SutureScene& scene) {
  auto& [name, source_location, incision, body, spacing, bite, depth, through, is_running, material, thread,
         diameter, thread_length, pull_out, pull] = scene;
  transfer_all(file, name, source_location, incision, body, spacing, bite, depth, through, is_running,
               material, thread, diameter, thread_length, pull_out, pull);
}
template <class File>
void transfer(File& file, Suture& suture) {
  auto& [scene, closure] = suture;
  transfer_all(file, scene, closure);
}

/// True if bodies and wounds that cuts and stitches refer to exist.
bool has_wounds_of_stitches(const World& world) {
  const auto is_index = [](int index, std::size_t count) { return index >= 0 && std::size_t(index) < count; };
  return std::all_of(world.cuts.begin(), world.cuts.end(),
                     [&](const Cut& cut) { return is_index(cut.body, world.lattice_bodies.size()); }) &&
         std::all_of(world.sutures.begin(), world.sutures.end(), [&](const Suture& suture) {
           return is_index(suture.scene.body, world.lattice_bodies.size()) &&
                  is_index(suture.scene.incision, world.cuts.size());
         });
}

/// Cuts and sutures with their scene tables: those by hand follow those of the scene.
template <class File>
void transfer_world(File& file, World& world) {
  transfer(file, world.frame);
  for_each_body(world, [&](BodyId, auto& body) { transfer_body(file, body); });
  transfer_coupling(file, world.coupling);
  transfer_all(file, world.cuts, world.sutures);
  if constexpr (File::kReads)
    if (!has_wounds_of_stitches(world)) file.fail();
  for (TouchingTool& tool : world.tools)
    transfer_all(file, tool.path, tool.hand, tool.grip, tool.samples, tool.limits, tool.needle_work,
                 tool.punctures, tool.entry_force);
}

/// With a store on demand: fetches the columns of Green's functions for patches and forces of the state.
void fetch_columns_in_use(const Exec& exec, SfemBody& body) {
  if (!body.facts.on_demand) return;
  std::vector<int> vertices;
  for (const SharedPatch& patch : body.patches)
    if (patch) vertices.insert(vertices.end(), patch->coarse.begin(), patch->coarse.end());
  if (body.now.patch)
    for (const contact::VertexForce& force : coarse_forces_now(body)) vertices.push_back(force.vertex);
  sort_unique(vertices);
  sfem::fetch_columns(exec, body.model, vertices);
}

}  // namespace

LoadedPatches loaded_patches(const World& world) {
  LoadedPatches loaded;
  for (const SfemBody& body : world.sfem_bodies) loaded.patches.push_back(body.touch.patch);
  return loaded;
}

std::uint64_t loaded_hash(const World& world) {
  std::uint64_t hash = state_hash(world);
  const auto add = [&hash](std::uint64_t more) { hash = hash_bytes(&more, sizeof more, hash); };
  for (const LatticeBody& body : world.lattice_bodies) add(body.ct_hash);
  for (const SfemBody& body : world.sfem_bodies)
    add(hash_values(std::span<const Vec3d>(body.model.body.mesh.vertices)));
  for (const RhombusBody& body : world.rhombus_bodies)
    add(hash_values(std::span<const Vec3d>(rest_surface(body).vertices)));
  for (const ClothBody& body : world.cloth_bodies) add(std::uint64_t(body.model.count));
  for (const RigidBody& body : world.rigid_bodies)
    add(hash_values(std::span<const Vec3d>(body.model.vertices)));
  return hash;
}

void write_world(StateWriter& file, const World& world, const LoadedPatches& loaded) {
  WorldFile<StateWriter> out{file, loaded.patches};
  transfer_world(out, const_cast<World&>(world));  // a writer changes nothing
}

void read_world(const Exec& exec, StateReader& file, const LoadedPatches& loaded, World& world) {
  WorldFile<StateReader> in{file, loaded.patches};
  transfer_world(in, world);
  if (!file.is_sound()) return;
  for (SfemBody& body : world.sfem_bodies) fetch_columns_in_use(exec, body), restore_needles(exec, body);
}

}  // namespace turgor

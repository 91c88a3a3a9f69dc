#include "turgor/sim/bodies/cloth/cloth_support.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/model/moving_mass.hpp"
#include "turgor/models/lattice/model/whole_motion.hpp"
#include "turgor/sim/bodies/cloth/free_support.hpp"
#include "turgor/sim/organs/cloth_attachments.hpp"
#include "turgor/sim/organs/free_lattice.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Collects the vertices of a body's triangles and renumbers the triangles.
void use_vertices(const std::vector<Int3>& triangles, ClothSupport& support) {
  TURGOR_CHECK(support.carrier.empty() && support.triangles.empty(),
               "the vertices of a support are listed once");
  for (const Int3 t : triangles) support.carrier.insert(support.carrier.end(), {t.x, t.y, t.z});
  sort_unique(support.carrier);
  const auto index_of = [&](int v) {
    return int(std::lower_bound(support.carrier.begin(), support.carrier.end(), v) - support.carrier.begin());
  };
  for (const Int3 t : triangles) support.triangles.push_back({index_of(t.x), index_of(t.y), index_of(t.z)});
}

/// Rest positions plus displacements of the support's vertices.
std::vector<Vec3> displaced(const ClothSupport& support, const std::vector<Vec3d>& rest,
                            const std::vector<Vec3d>& displacement) {
  TURGOR_CHECK(displacement.size() == rest.size(), "every vertex has a displacement");
  std::vector<Vec3> positions;
  for (const int v : support.carrier)
    positions.push_back(Vec3(rest[std::size_t(v)] + displacement[std::size_t(v)]));
  return positions;
}

std::vector<Vec3> surface_positions(const Exec& exec, LatticeBody& body, ClothSupport& support) {
  refresh_surface(exec, body);
  support.carrier = body.surface.slot, support.triangles = body.surface.triangles;
  if (!body.model.anatomy.cell_center.empty()) std::iota(support.carrier.begin(), support.carrier.end(), 0);
  return lattice::deformed_surface(body.model, body.state, body.surface, lattice::Shown::kNothing, exec)
      .vertices;
}

std::vector<Vec3> surface_positions(const Exec& exec, SfemBody& body, ClothSupport& support) {
  if (support.carrier.empty()) use_vertices(body.model.surface.triangles, support);
  return displaced(support, body.model.body.mesh.vertices, coarse_displacements(exec, body));
}

std::vector<Vec3> surface_positions(const Exec&, RhombusBody& body, ClothSupport& support) {
  if (support.carrier.empty()) use_vertices(body.model.surface.triangles, support);
  return displaced(support, body.model.surface.vertices, body.state.displacement);
}

/// A rigid body is at the end of the frame already.
std::vector<Vec3> surface_positions(const Exec&, RigidBody& body, ClothSupport& support) {
  if (support.carrier.empty()) use_vertices(body.model.triangles, support);
  const Pose pose = rigid::pose_of(body.model, body.next);
  std::vector<Vec3> positions;
  for (const int v : support.carrier)
    positions.push_back(Vec3(to_world(pose, body.model.vertices[std::size_t(v)])));
  return positions;
}

/// Bodies that tools can touch can support cloth.
std::vector<Vec3> surface_positions(const Exec& exec, ClothSupport& support, World& world) {
  return visit_body(world, support.body, [&](auto& body) -> std::vector<Vec3> {
    if constexpr (requires { surface_positions(exec, body, support); })
      return surface_positions(exec, body, support);
    return {};
  });
}

}  // namespace

std::vector<lattice::NodeLoad> node_loads(const LatticeBody& body) {
  const Mat3d to_lattice = transposed(body.model.anatomy.grid.axes);
  std::vector<lattice::NodeLoad> loads;
  for (const auto& [slot, f] : body.cloth.force) loads.push_back({slot, Vec3(to_lattice * f)});
  return loads;
}

void update_support(const Exec& exec, ClothSupport& support, bool is_free, World& world) {
  TURGOR_CHECK(is_step_length(world.dt), "a frame has a positive length");
  std::vector<Vec3> now = surface_positions(exec, support, world);
  if (is_free) support.positions = positions_before(world, support);
  const bool comparable = support.positions.size() == now.size();
  const TriMesh from{.vertices = comparable ? support.positions : now, .triangles = support.triangles};
  support.moving = cloth::moving_surface(from, comparable ? now : std::vector<Vec3>(), world.dt);
  support.positions = std::move(now);
}

void record_force(const cloth::State& state, int obstacle, double dt, ClothSupport& support) {
  TURGOR_ASSERT(support.moving != nullptr, "a support moves before its forces are recorded");
  TURGOR_CHECK(is_step_length(dt), "impulses become forces over a step of positive length");
  std::vector<Vec3d> impulse(support.carrier.size());
  cloth::add_surface_impulses(state, obstacle, *support.moving, dt, impulse);
  support.force.clear();
  for (std::size_t v = 0; v < impulse.size(); v++)
    if (impulse[v] != Vec3d{}) support.force.push_back({support.carrier[v], impulse[v] / dt});
}

/// Mass with the inertia of a sheet's stiffness over a frame [kg]. A free body of finite elements sticks to
/// the sheet, which resists what it deforms along it, and does so a frame later.
static double stiffness_as_mass(const World& world, const ClothBody& cloth, BodyId body) {
  constexpr double kSides = 2;  // of a loaded vertex, along each thread
  if (body.kind != BodyKind::kSfem || !moves_with(world, cloth, body)) return 0;
  const cloth::Fabric& fabric = cloth.model.params.fabric;
  return kSides * (fabric.warp + fabric.weft) * world.dt * world.dt;
}

ClothForces cloth_forces_on(const World& world, BodyId body) {
  ClothForces forces;
  for (const ClothBody& cloth : world.cloth_bodies) {
    bool touches = false;
    for (const ClothObstacle& obstacle : cloth.obstacles) {
      if (!obstacle.support || obstacle.support->body != body) continue;
      const auto& force = obstacle.support->force;
      touches = touches || !force.empty();
      if (body.kind == BodyKind::kRigid && moves_with(world, cloth, body)) continue;  // RigidBody::borne
      forces.force.insert(forces.force.end(), force.begin(), force.end());
    }
    if (touches) forces.mass += cloth.model.total_mass + stiffness_as_mass(world, cloth, body);
  }
  for (const CoupledSupport& support : world.coupling.supports) {
    if (support.body != body) continue;
    forces.force.insert(forces.force.end(), support.force.begin(), support.force.end());
    forces.solved = support.solved;
    forces.stiffness += support.stiffness;
    forces.moves_whole = moves_whole(world, support);
  }
  add_cloth_attachments(world, body, forces);
  return forces;
}

/// Bound of the mean displacement of the loaded nodes per force: that of a half space under a disk of their
/// area, 0.4/(E a), and the motion of the whole body by its inertia [m/N].
static double elastic_compliance(const LatticeBody& body, const ClothLoad& load, double dt) {
  constexpr double kBound = 2;  // layers of little stiffness below the skin
  const lattice::Anatomy& anatomy = body.model.anatomy;
  const Vec3d h(anatomy.lattice.spacing);
  // softest loaded cell
  double young = HUGE_VAL;
  for (const auto& [slot, f] : load.force)
    if (std::size_t(slot) < anatomy.cell_young.size())
      if (const double e = double(anatomy.cell_young[std::size_t(slot)]); e > 0) young = std::min(young, e);
  if (!std::isfinite(young)) young = body.model.params.tissue.fat;
  const double mass = lattice::moving_mass(anatomy);
  const auto nodes = std::count_if(load.force.begin(), load.force.end(),
                                   [&](const auto& loaded) { return !is_rim(body.model, loaded.vertex); });
  const double area = double(nodes) * std::cbrt(h.x * h.y * h.z) * std::cbrt(h.x * h.y * h.z);
  const double radius = std::sqrt(area / std::numbers::pi);
  return kBound * (0.4 / (young * radius) + (mass > 0 ? dt * dt / mass : 0));
}

/// Adds to the velocities of a body what the relaxed load leaves out of the forces: their sum and their
/// torque, as an acceleration of the whole body.
static void move_by_rest(const ClothForces& forces, double dt, LatticeBody& body) {
  const lattice::WholeMotion whole = lattice::whole_motion(body.model, *body.state);
  const Mat3d to_lattice = transposed(body.model.anatomy.grid.axes);
  Vec3d force, torque;
  const auto add = [&](const contact::VertexForce& at, double sign) {
    const Vec3d f = to_lattice * at.force * sign;
    force += f;
    torque += cross(lattice::node_position(body.model, *body.state, at.vertex) - whole.center, f);
  };
  for (const contact::VertexForce& f : forces.force) add(f, 1);
  for (const contact::VertexForce& f : body.cloth.force) add(f, -1);
  if (force == Vec3d{} && torque == Vec3d{}) return;
  lattice::add_velocity(body.model, whole.center, force * (dt / whole.mass),
                        whole.inverse_inertia * torque * dt, body.state.change());
}

/// Compliance of a lattice. A node accelerated by a force f moves by at most w f h², since its neighbors
/// restrain it. A rim node has almost no mass: the tissue of its cell restrains it like a node of tissue.
void press_body(const Exec&, LatticeBody& body, const ClothForces& forces, double dt) {
  TURGOR_CHECK(std::all_of(forces.force.begin(), forces.force.end(),
                           [&](const contact::VertexForce& f) {
                             return is_index(f.vertex, body.model.anatomy.inverse_mass.size());
                           }),
               "cloth presses slots of the lattice");
  // relax the load toward the new forces
  ClothLoad& load = body.cloth;
  relax_toward(forces, load);
  if (forces.moves_whole) move_by_rest(forces, dt, body);
  // compliance from the largest acceleration
  constexpr double kDensity = 1000;  // of tissue [kg/m³]
  const double of_tissue = 1 / (kDensity * sample_volume(body.model.anatomy.grid));
  double largest = 0;
  for (const auto& [slot, f] : load.force) {
    const double w = double(body.model.anatomy.inverse_mass[std::size_t(slot)]);
    largest = std::max(largest, norm(f) * (is_rim(body.model, slot) ? std::min(w, of_tissue) : w));
  }
  const double sum = sum_of_norms(load), compliance = sum > 0 ? largest * dt * dt / sum : 0;
  load.compliance = {compliance, compliance, compliance};
  // relaxation for the cloth's mass, and for the stiffness of touching bodies as a mass of that inertia
  double mass = forces.mass;
  if (forces.stiffness > 0 && compliance > 0)
    mass += forces.stiffness * dt * dt * std::min(1.0, elastic_compliance(body, load, dt) / compliance);
  choose_relaxation(mass, dt, load);
  // the impulse of a collision arrives whole at a constant relaxation, which a body that nothing fixes needs;
  // it is stable for twice the gain that choose_relaxation permits
  constexpr double kOfFreeBodies = 0.1;
  const lattice::Anatomy& anatomy = body.model.anatomy;
  if (anatomy.free_nodes == anatomy.body_nodes && load.relaxation > kOfFreeBodies / 2)
    load.relaxation = kOfFreeBodies;
}

}  // namespace turgor

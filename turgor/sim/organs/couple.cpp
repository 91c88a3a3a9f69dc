#include <algorithm>
#include <numeric>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/sfem/surface_strain.hpp"
#include "turgor/sim/organs/free_lattice.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr int kMostLinearizations = 5;        // of the motion of rigid bodies, in a frame
constexpr double kLinearizationError = 1e-6;  // of the size of the body

/// 1 for every body that an attachment or a contact concerns.
std::vector<std::uint8_t> coupled_bodies(const World& world) {
  std::vector<std::uint8_t> coupled(std::size_t(first_tool(world)), 0);
  for (const Attachment& attachment : world.coupling.attachments)
    for (const contact::Tie& tie : attachment.ties)
      for (const int body : {tie.a.body, tie.b.body})
        if (body >= 0) coupled[std::size_t(body)] = 1;
  for (const BodyContact& contact : world.coupling.contacts)
    for (const int body : contact.body)
      if (body >= 0) coupled[std::size_t(body)] = 1;
  return coupled;
}

/// Positions of all vertices at the end of the frame.
std::vector<Vec3d> positions_now(const SfemBody& body, const std::vector<Vec3d>& by_tools) {
  std::vector<Vec3d> x = body.model.body.mesh.vertices;
  for (std::size_t v = 0; v < x.size(); v++) x[v] += by_tools[v];
  for (std::size_t v = 0; v < body.free.before.size(); v++) x[v] += body.free.before[v];
  return x;
}

/// Records the strain of the whole surface, which other bodies load beside the patch under a tool.
void record_strain(SfemBody& body, const std::vector<Vec3d>& x) {
  if (body.turning) return;
  const sfem::Model& model = body.model;
  body.surface_strain =
      std::max(body.surface_strain,
               sfem::largest_surface_strain(model.surface.triangles, model.body.mesh.vertices, x));
}

/// Surface of a body at the present positions of its vertices. `near` receives the triangles of a support
/// that are near `other`, the vertices of the other body.
contact::PairSurface surface_now(const World& world, int index, const std::vector<Vec3d>& x,
                                 const std::vector<double>& rest_height, const std::vector<Vec3d>& other,
                                 double reach, std::vector<Int3>& near) {
  if (index >= first_support(world)) {
    const CoupledSupport& support = world.coupling.supports[std::size_t(index - first_support(world))];
    near = triangles_near(support, x, other, reach);
    return {.body = index,
            .rest = support.rest,
            .x = x,
            .triangles = near,
            .rest_height = rest_height,
            .by_vertices = support.body.kind == BodyKind::kLattice};
  }
  if (const RigidBody* body = rigid_body(world, index)) return rigid_surface(*body, index, x);
  const sfem::Model& model = world.sfem_bodies[std::size_t(index)].model;
  return {index, model.body.mesh.vertices, x, model.surface.triangles, rest_height};
}

/// Distance that the points of a rigid body or a free lattice may move in the next frame [m].
double distance_ahead(const World& world, int index) {
  if (index >= first_support(world)) {
    const CoupledSupport& support = world.coupling.supports[std::size_t(index - first_support(world))];
    return moves_whole(world, support) ? farthest_ahead(world, support) : 0;
  }
  const RigidBody* body = index < 0 ? nullptr : rigid_body(world, index);
  if (!body || body->model.is_fixed) return 0;
  return world.dt * (rigid::largest_speed(body->model, body->state) + world.dt * norm(world.gravity));
}

/// Finds the sites of a contact at the present positions.
void update_sites(const Exec& exec, const World& world, const std::vector<std::vector<Vec3d>>& x,
                  BodyContact& contact) {
  contact::PairParams params = contact.params;
  for (const int body : contact.body) params.reach += distance_ahead(world, body);
  std::array<std::vector<Int3>, 2> near;
  const auto surface = [&](std::size_t side) {
    const auto body = std::size_t(contact.body[side]), other = std::size_t(contact.body[1 - side]);
    return surface_now(world, int(body), x[body], contact.rest_height[side], x[other],
                       params.reach + params.deepest, near[side]);
  };
  contact::PairSites found;
  if (contact.body[1] < 0) {
    const auto body = std::size_t(contact.body[0]);
    found = contact::find_ground_sites(
        surface_now(world, int(body), x[body], contact.rest_height[0], {}, 0, near[0]), contact.ground,
        params, contact.sites);
  } else if (const std::array surfaces{surface(0), surface(1)};
             !surfaces[0].triangles.empty() && !surfaces[1].triangles.empty()) {
    found = contact::find_pair_sites(exec, surfaces, params, contact.sites);
  }
  contact.sites = std::move(found.sites);
  contact.dropped_most = std::max(contact.dropped_most, found.dropped);
  contact.deepest = std::max(contact.deepest, found.deepest);
}

CouplingSample sample_of(double time, const std::vector<contact::Tie>& ties) {
  CouplingSample sample{.time = time, .force = total_force(ties)};
  for (const contact::Tie& tie : ties)
    sample.most = std::max(sample.most, norm(tie.force)), sample.bearing += tie.force != Vec3d{};
  return sample;
}
CouplingSample sample_of(double time, const std::vector<contact::PairSite>& sites, int body) {
  CouplingSample sample{.time = time, .force = total_force(sites, body)};
  for (const contact::PairSite& site : sites) {
    sample.most = std::max(sample.most, norm(site.force)), sample.bearing += site.force != Vec3d{};
    sample.sliding += site.state == contact::SiteState::kSlip;
  }
  return sample;
}

/// visit(ties, sites) for every attachment, every contact, and every tool on a rigid body.
template <class Visit>
void for_each_list(World& world, const Visit& visit) {
  std::vector<contact::Tie> no_ties;
  std::vector<contact::PairSite> no_sites;
  for (Attachment& attachment : world.coupling.attachments)
    if (attachment.swept < 0) visit(attachment.ties, no_sites);
  for (BodyContact& contact : world.coupling.contacts)
    if (contact.swept < 0) visit(no_ties, contact.sites);
  for (RigidBody& body : world.rigid_bodies)
    for (RigidTouch& touch : body.touches) visit(touch.grasp, touch.sites);
}

/// All ties and sites in one list, solved, and put back.
contact::CouplingReport solve_all(const Exec& exec, const std::vector<contact::CoupledBody>& bodies,
                                  World& world, std::vector<contact::Tie>& ties,
                                  std::vector<contact::PairSite>& sites) {
  for_each_list(world, [&](const auto& some_ties, const auto& some_sites) {
    ties.insert(ties.end(), some_ties.begin(), some_ties.end());
    sites.insert(sites.end(), some_sites.begin(), some_sites.end());
  });
  const contact::CouplingReport report =
      contact::solve_coupling(exec, bodies, ties, sites, world.coupling.storage);
  auto tie = ties.begin();
  auto site = sites.begin();
  for_each_list(world, [&](auto& some_ties, auto& some_sites) {
    std::copy_n(tie, some_ties.size(), some_ties.begin()), tie += std::ptrdiff_t(some_ties.size());
    std::copy_n(site, some_sites.size(), some_sites.begin()), site += std::ptrdiff_t(some_sites.size());
  });
  return report;
}

/// State of a rigid body after the next frame under a load, besides its weight and cloth.
rigid::State state_after(const World& world, const RigidBody& body, const contact::RigidLoad& load) {
  const contact::RigidLoad cloth = cloth_load_on(body);
  const Vec3d impulse = (load.force + cloth.force + world.gravity * body.model.mass.mass) * world.dt;
  return rigid::moved(body.model, body.state, impulse, (load.torque + cloth.torque) * world.dt, world.dt);
}

Pose center_pose(const rigid::State& state) { return {state.center, axes_of(state.rotation)}; }

/// Motion of a rigid body in the next frame, around that without forces of the coupling.
contact::RigidMotion free_motion(const World& world, const RigidBody& body) {
  const double square = world.dt * world.dt;
  contact::RigidMotion motion{.rest_center = body.model.mass.center,
                              .before = center_pose(body.state),
                              .after = {},
                              .shift = {},
                              .turn = {}};
  motion.translation = body.model.is_fixed ? 0 : square / body.model.mass.mass;
  motion.rotation = rigid::inverse_inertia(body.model, body.state.rotation);
  for (Vec3d& column : motion.rotation.column) column *= square;
  contact::linearize(center_pose(state_after(world, body, {})), {}, motion);
  return motion;
}

/// Linearizes the motion of all rigid bodies around their loads, and sets their next states. True if their
/// points reach the positions that the solution has.
bool linearize_rigid(World& world, std::span<const contact::Tie> ties,
                     std::span<const contact::PairSite> sites, std::vector<contact::CoupledBody>& bodies) {
  bool is_exact = true;
  for (std::size_t n = 0; n < world.rigid_bodies.size(); n++) {
    RigidBody& body = world.rigid_bodies[n];
    const std::size_t b = world.sfem_bodies.size() + n;
    contact::RigidMotion& motion = *bodies[b].rigid;
    const contact::RigidLoad load = contact::load_on(int(b), motion, ties, sites);
    body.next = state_after(world, body, load);
    const Pose after = center_pose(body.next);
    is_exact = is_exact && contact::linearization_error(int(b), motion, after, load, ties, sites) <=
                               kLinearizationError * body.radius;
    contact::linearize(after, load, motion);
  }
  return is_exact;
}

/// Solves for all forces, with the motion of rigid bodies linearized around the solution.
contact::CouplingReport solve_motion(const Exec& exec, World& world,
                                     std::vector<contact::CoupledBody>& bodies,
                                     std::vector<contact::Tie>& ties, std::vector<contact::PairSite>& sites) {
  contact::CouplingReport report;
  for (int n = 0; n < kMostLinearizations; n++) {
    ties.clear(), sites.clear();
    report = solve_all(exec, bodies, world, ties, sites);
    if (linearize_rigid(world, ties, sites, bodies)) break;
  }
  return report;
}

/// Free motion of the next frame, and positions at the end of this one.
std::vector<contact::CoupledBody> coupled_motions(const Exec& exec, World& world,
                                                  const std::vector<std::uint8_t>& coupled,
                                                  std::vector<std::vector<Vec3d>>& x) {
  const std::size_t count = world.sfem_bodies.size();
  x.resize(std::size_t(first_tool(world)));
  std::vector<contact::CoupledBody> bodies(x.size() + world.tools.size());
  for (std::size_t b = 0; b < count; b++) {
    SfemBody& body = world.sfem_bodies[b];
    if (!coupled[b] && !body.flight) continue;
    std::vector<Vec3d> by_tools = tool_displacement(exec, body);
    x[b] = positions_now(body, by_tools);
    record_strain(body, x[b]);
    if (body.flight) advance_flight(body, by_tools, world.gravity, world.dt);
    bodies[b] = {.model = &body.model,
                 .stiffness_scale = body.stiffness_scale,
                 .free = uncoupled_displacement(body, std::move(by_tools)),
                 .rigid = {}};
    if (!coupled[b]) sum_free_motion(body);
  }
  for (std::size_t n = 0; n < world.rigid_bodies.size(); n++) {
    RigidBody& body = world.rigid_bodies[n];
    const Pose pose = rigid::pose_of(body.model, body.state);
    for (const Vec3d rest : body.model.vertices) x[count + n].push_back(to_world(pose, rest));
    bodies[count + n].rigid = free_motion(world, body);
    body.next = state_after(world, body, {});
  }
  auto s = std::size_t(first_support(world));
  for (const CoupledSupport& support : world.coupling.supports) {
    bodies[s].free = support_displacement(world, support), bodies[s].is_support = true;
    x[s] = support.rest;
    for (std::size_t v = 0; v < x[s].size(); v++) x[s][v] += bodies[s].free[v];
    if (moves_whole(world, support)) bodies[s].inertia = move_ahead(world, support, x[s], bodies[s].free);
    if (support.body.kind == BodyKind::kRhombus) {
      // chains yield to the forces of this solution instead of the last one
      const RhombusBody& body = world.rhombus_bodies[std::size_t(support.body.index)];
      bodies[s] = {.stiffness_scale = body.stiffness_scale,
                   .free = displacement_without(exec, body, support.solved),
                   .rigid = {},
                   .chains = &body.model};
    }
    s++;
  }
  return bodies;
}

/// Finds the sites of the tools on rigid bodies in the next frame, which ends at a time. True if there are
/// tools.
bool find_touches(const Exec& exec, World& world, const std::vector<std::vector<Vec3d>>& x, double end,
                  std::vector<contact::CoupledBody>& bodies) {
  bool is_touched = false;
  const int first = first_tool(world);
  for (std::size_t n = 0; n < world.rigid_bodies.size(); n++) {
    RigidBody& body = world.rigid_bodies[n];
    const std::size_t b = world.sfem_bodies.size() + n;
    find_tool_sites(exec, world, body, int(b), first, rigid_surface(body, int(b), x[b]), end);
    for (std::size_t t = 0; t < body.touches.size(); t++)
      bodies[std::size_t(first + body.tool_indices[t])].rigid = tool_motion(body.touches[t]);
    is_touched = is_touched || !body.touches.empty();
  }
  return is_touched;
}

/// Solves for the forces of the next frame, which ends at a time, and for the motion that they cause.
void solve_frame(const Exec& exec, World& world, double end) {
  Coupling& coupling = world.coupling;
  const std::vector<std::uint8_t> coupled = coupled_bodies(world);
  std::vector<std::vector<Vec3d>> x;
  std::vector<contact::CoupledBody> bodies = coupled_motions(exec, world, coupled, x);
  const bool is_touched = find_touches(exec, world, x, end, bodies);
  if (is_empty(coupling) && !is_touched) return;

  // sites and forces
  for (BodyContact& contact : coupling.contacts)
    if (contact.swept < 0) update_sites(exec, world, x, contact);
  std::vector<contact::Tie> ties;
  std::vector<contact::PairSite> sites;
  remember_supports(world);
  const contact::CouplingReport report = solve_motion(exec, world, bodies, ties, sites);
  forget_supports(world);
  coupling.frames++, coupling.unsolved += !report.converged;

  // motion that they cause
  for (std::size_t b = 0; b < world.sfem_bodies.size(); b++)
    if (coupled[b]) couple_body(exec, world.sfem_bodies[b], contact::forces_on(int(b), ties, sites));
  load_supports(world, ties, sites);
  for (RigidBody& body : world.rigid_bodies) read_tool_loads(body, first_tool(world));
}

}  // namespace

Vec3d total_force(const std::vector<contact::Tie>& ties) {
  return std::accumulate(ties.begin(), ties.end(), Vec3d{},
                         [](Vec3d sum, const contact::Tie& tie) { return sum + tie.force; });
}
Vec3d total_force(const std::vector<contact::PairSite>& sites, int body) {
  Vec3d sum;
  for (const contact::PairSite& site : sites)
    sum += site.a.body == body ? site.force : site.b.body == body ? -site.force : Vec3d{};
  return sum;
}

void begin_coupling(const Exec& exec, World& world) {
  if (!world.rigid_bodies.empty()) solve_frame(exec, world, world.dt);
  find_swept(exec, world);
}

void couple_bodies(const Exec& exec, World& world) {
  solve_frame(exec, world, (world.frame + 2) * world.dt);
  Coupling& coupling = world.coupling;
  // record at the end of this frame
  const double time = (world.frame + 1) * world.dt;
  for (Attachment& attachment : coupling.attachments) {
    attachment.samples.push_back(sample_of(time, attachment.ties));
    const bool is_torn = std::any_of(attachment.ties.begin(), attachment.ties.end(),
                                     [](const contact::Tie& tie) { return tie.broken; });
    if (is_torn && attachment.torn_at == 0) attachment.torn_at = time;
  }
  for (BodyContact& contact : coupling.contacts) {
    CouplingSample sample = sample_of(time, contact.sites, contact.body[0]);
    sample.force -= contact.unbalanced * (contact.swept == 0 ? 1 : -1);
    contact.samples.push_back(sample);
  }
  find_swept(exec, world);
}

std::uint64_t state_hash(const Coupling& coupling, std::uint64_t seed) {
  for (const Attachment& attachment : coupling.attachments)
    for (const contact::Tie& tie : attachment.ties) seed = hash_bytes(&tie.force, sizeof tie.force, seed);
  for (const BodyContact& contact : coupling.contacts)
    for (const contact::PairSite& site : contact.sites)
      seed = hash_bytes(&site.force, sizeof site.force, seed);
  return seed;
}

}  // namespace turgor

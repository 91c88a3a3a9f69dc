#include "turgor/sim/organs/support.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/geometry/box.hpp"
#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

const CoupledSupport* support_at(const World& world, int index) {
  const int n = index - first_support(world);
  return n < 0 ? nullptr : &world.coupling.supports[std::size_t(n)];
}

/// Young's modulus near a vertex of a lattice: of the stiffest cell around its node [Pa].
double young_near(const LatticeBody& body, int slot) {
  const lattice::Anatomy& anatomy = body.model.anatomy;
  double most = 0;
  if (std::size_t(slot) >= anatomy.tissue.size()) return body.model.params.tissue.fat;
  const Int3 node = slot_node(anatomy.lattice, slot);
  for (int corner = 0; corner < 8; corner++) {
    const Int3 cell = node - Int3{corner & 1, corner >> 1 & 1, corner >> 2};
    if (!contains(anatomy.lattice, cell) || anatomy.cell_young.empty()) continue;
    most = std::max(most, double(anatomy.cell_young[std::size_t(node_slot(anatomy.lattice, cell))]));
  }
  return most > 0 ? most : body.model.params.tissue.fat;
}

/// First vertex of the support in a contact, from its sites.
int vertex_of(const BodyContact& contact, int index) {
  for (const contact::PairSite& site : contact.sites)
    for (const contact::SurfacePoint* point : {&site.a, &site.b})
      if (point->body == index) return point->vertex.x;
  return 0;
}

/// Lattice of a contact that is solved together with the other body.
struct TouchedLattice {
  const LatticeBody& body;
  double softness;  // of a site [m/N]
};
std::optional<TouchedLattice> touched_lattice(const World& world, const BodyContact& contact) {
  // sites share a node, and tissue around yields less than a node alone: a ball comes to rest with 0.4, and
  // trembles with 1 (tests/sim/organs/ball_at_rest.cpp)
  constexpr double kOfNode = 0.4;
  if (contact.swept >= 0 || contact.sites.empty()) return {};
  for (const int index : contact.body)
    if (const CoupledSupport* support = support_at(world, index);
        support && support->body.kind == BodyKind::kLattice)
      return TouchedLattice{world.lattice_bodies[std::size_t(support->body.index)],
                            kOfNode * node_softness(world, *support, vertex_of(contact, index))};
  return {};
}

/// Moves a site by the compliance times a force. Sites that roll move over the surfaces, so that only their
/// motion in a frame is resisted.
void move_site(double softness, Vec3d force, contact::PairSite& site) {
  const double along = dot(force, site.normal);
  site.distance -= softness * along;
  const bool rolls = site.rolls || site.a.offset != Vec3d{} || site.b.offset != Vec3d{};
  if (!rolls) site.slip += softness * (force - along * site.normal);
}

/// Forces on vertices as forces on what carries them: nodes, the corners of cells, or vertices of a model.
std::vector<contact::VertexForce> on_carriers(const CoupledSupport& support,
                                              const std::vector<contact::VertexForce>& forces) {
  std::vector<contact::VertexForce> on;
  for (const auto& [vertex, force] : forces) {
    if (support.cell.empty()) {
      on.push_back({support.carrier[std::size_t(vertex)], force});
      continue;
    }
    const lattice::EmbeddedPoint& cell = support.cell[std::size_t(vertex)];
    for (std::size_t c = 0; c < 8; c++)
      if (cell.weight[c] != 0) on.push_back({cell.corner[c], force * double(cell.weight[c])});
  }
  return on;
}

/// Stiffness with which a body resists a displacement of the points where these forces act [N/m].
double resisting_stiffness(const World& world, int index, const std::vector<contact::Tie>& ties,
                           const std::vector<contact::PairSite>& sites) {
  if (const RigidBody* body = rigid_body(world, index))
    return body->model.is_fixed ? HUGE_VAL : body->model.mass.mass / (world.dt * world.dt);
  if (index < 0 || index >= first_support(world)) return HUGE_VAL;
  // force over displacement, weighted by the forces
  const SfemBody& body = world.sfem_bodies[std::size_t(index)];
  Vec3d force;
  double work = 0;
  for (const contact::VertexForce& f : contact::forces_on(index, ties, sites)) {
    force += f.force;
    if (body.coupling) work += dot(f.force, body.coupling->displacement[std::size_t(f.vertex)]);
  }
  return work > 0 ? dot(force, force) / work : 0;
}

/// Stiffness of everything that a lattice touches and holds.
double stiffness_around(const World& world, int index) {
  double sum = 0;
  for (const Attachment& attachment : world.coupling.attachments) {
    if (attachment.ties.empty() || attachment.swept >= 0) continue;
    const int a = attachment.ties[0].a.body, b = attachment.ties[0].b.body;
    if (a != index && b != index) continue;
    const double other = resisting_stiffness(world, a == index ? b : a, attachment.ties, {});
    if (other > 0) sum += 1 / (1 / attachment.stiffness + 1 / other);
  }
  for (const BodyContact& contact : world.coupling.contacts)
    for (std::size_t side = 0; side < 2; side++)
      if (contact.body[side] == index && !contact.sites.empty() && contact.swept < 0)
        sum += resisting_stiffness(world, contact.body[1 - side], {}, contact.sites);
  return sum + swept_stiffness_on(world, index);
}

}  // namespace

int first_support(const World& world) { return int(world.sfem_bodies.size() + world.rigid_bodies.size()); }
int first_tool(const World& world) { return first_support(world) + int(world.coupling.supports.size()); }

const RigidBody* rigid_body(const World& world, int index) {
  const int n = index - int(world.sfem_bodies.size());
  return n < 0 || index >= first_support(world) ? nullptr : &world.rigid_bodies[std::size_t(n)];
}

double node_softness(const World& world, const CoupledSupport& support, int vertex) {
  const auto index = std::size_t(support.body.index);
  if (support.body.kind == BodyKind::kRhombus) return 0.01 / world.rhombus_bodies[index].typical_force;
  const LatticeBody& body = world.lattice_bodies[index];
  const Vec3d h(body.model.anatomy.lattice.spacing);
  return 1 / (young_near(body, support.carrier[std::size_t(vertex)]) * std::cbrt(h.x * h.y * h.z));
}

std::vector<Int3> triangles_near(const CoupledSupport& support, const std::vector<Vec3d>& x,
                                 const std::vector<Vec3d>& other, double reach) {
  if (other.empty()) return support.triangles;
  Box near = box_around(other);
  near.low -= Vec3d{reach, reach, reach}, near.high += Vec3d{reach, reach, reach};
  std::vector<Int3> triangles;
  for (const Int3 t : support.triangles) {
    const std::array<Vec3d, 3> corners{x[std::size_t(t.x)], x[std::size_t(t.y)], x[std::size_t(t.z)]};
    if (meet(near, box_around(corners))) triangles.push_back(t);
  }
  return triangles;
}

void remember_supports(World& world) {
  for (BodyContact& contact : world.coupling.contacts) {
    const std::optional<TouchedLattice> lattice = touched_lattice(world, contact);
    if (!lattice) continue;
    for (contact::PairSite& site : contact.sites) {
      site.softness = lattice->softness;
      move_site(site.softness, site.borne, site);
    }
  }
}

void forget_supports(World& world) {
  for (BodyContact& contact : world.coupling.contacts) {
    const std::optional<TouchedLattice> lattice = touched_lattice(world, contact);
    if (!lattice) continue;
    for (contact::PairSite& site : contact.sites) {
      move_site(-site.softness, site.borne, site);
      site.borne += (site.force - site.borne) * lattice->body.cloth.relaxation;
    }
  }
}

void load_supports(World& world, std::span<const contact::Tie> ties,
                   std::span<const contact::PairSite> sites) {
  Coupling& coupling = world.coupling;
  for (std::size_t n = 0; n < coupling.supports.size(); n++) {
    CoupledSupport& support = coupling.supports[n];
    const int index = first_support(world) + int(n);
    const bool yields = support.body.kind == BodyKind::kRhombus;
    std::vector<contact::VertexForce> solved = contact::forces_on(index, ties, sites);
    support.force = swept_forces_on(world, index);
    if (!yields) support.force.insert(support.force.begin(), solved.begin(), solved.end());
    support.force = on_carriers(support, support.force);
    support.solved = yields ? std::move(solved) : std::vector<contact::VertexForce>();
    support.stiffness = yields ? swept_stiffness_on(world, index) : stiffness_around(world, index);
  }
}

}  // namespace turgor

#include "turgor/sim/organs/swept.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/contact/lattice_touch.hpp"
#include "turgor/contact/permit_depth.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/lattice/model/moving_mass.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/organs/swept_body.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

bool is_swept_by_lattice(const World& world, const Attachment& attachment) {
  if (attachment.swept < 0 || attachment.ties.empty()) return false;
  const contact::Tie& tie = attachment.ties[0];
  const int own = attachment.swept == 0 ? tie.a.body : tie.b.body;
  return swept_support(world, own).body.kind == BodyKind::kLattice;
}

/// Velocity of a vertex of a lattice [m/s].
Vec3d vertex_velocity(const CoupledSupport& support, int vertex, const lattice::Motion& motion) {
  const auto v = std::size_t(vertex);
  if (support.cell.empty()) return Vec3d(motion.v[std::size_t(support.carrier[v])]);
  return Vec3d(
      lattice::displacement(support.cell[v], [&](int corner) { return motion.v[std::size_t(corner)]; }));
}

std::vector<Vec3d> positions_of(const World& world, const CoupledSupport& support) {
  std::vector<Vec3d> x = support_displacement(world, support);
  for (std::size_t v = 0; v < x.size(); v++) x[v] += support.rest[v];
  return x;
}

/// Bodies of a contact: the swept one first.
struct SweptPair {
  int index = 0, other = 0;
  const CoupledSupport& own;
};
SweptPair swept_pair(const World& world, const BodyContact& contact) {
  const auto side = std::size_t(contact.swept);
  return {contact.body[side], contact.body[1 - side], swept_support(world, contact.body[side])};
}

/// Displacement of a node of a lattice that can touch, lattice frame [m].
Vec3d node_displacement(const SweptNodes& nodes, std::size_t n, const lattice::Motion& motion) {
  if (nodes.cell.empty()) return Vec3d(motion.u[std::size_t(nodes.slot[n])]);
  return Vec3d(lattice::displacement(nodes.cell[n], motion));
}

/// Present positions of the nodes of a lattice that can touch.
std::vector<Vec3d> positions_of_nodes(const World& world, const CoupledSupport& support) {
  const LatticeBody& body = lattice_of(world, support);
  const lattice::Motion& motion = body.state->motion;
  std::vector<Vec3d> x = support.nodes.rest;
  for (std::size_t n = 0; n < x.size(); n++)
    x[n] += patient_axes(body) * node_displacement(support.nodes, n, motion);
  return x;
}

/// Vertices of a rigid body.
std::vector<Vec3d> fixed_positions(const RigidBody& body) {
  const Pose pose = rigid::pose_of(body.model, body.state);
  std::vector<Vec3d> x;
  for (const Vec3d rest : body.model.vertices) x.push_back(to_world(pose, rest));
  return x;
}

/// Sites of a contact at the present positions.
contact::PairSites swept_sites(const Exec& exec, const World& world, const BodyContact& contact) {
  const SweptPair pair = swept_pair(world, contact);
  const std::vector<Vec3d> x = positions_of_nodes(world, pair.own);
  const contact::SurfaceNodes nodes{pair.own.nodes.rest, x, pair.own.nodes.vertex,
                                    contact.rest_height[std::size_t(contact.swept)]};
  contact::PairParams params = contact.params;
  params.reach += farthest_ahead(world, pair.own);
  if (pair.other < 0)
    return contact::find_node_sites(nodes, pair.index, contact.ground, params, contact.sites);
  const std::vector<Vec3d> own_x = positions_of(world, pair.own);
  if (const RigidBody* fixed = rigid_body(world, pair.other)) {
    const std::vector<Vec3d> fixed_x = fixed_positions(*fixed);
    const std::vector<Int3> near = triangles_near(pair.own, own_x, fixed_x, params.reach + params.deepest);
    if (near.empty()) return {};
    const std::array<contact::PairSurface, 2> surfaces{
        {{pair.index, pair.own.rest, own_x, near, {}}, rigid_surface(*fixed, pair.other, fixed_x)}};
    return contact::find_node_sites(exec, nodes, surfaces, params, contact.sites);
  }
  // surfaces near each other
  const CoupledSupport& other = swept_support(world, pair.other);
  params.reach += farthest_ahead(world, other);
  const double far = params.reach + params.deepest;
  const std::vector<Vec3d> other_x = positions_of(world, other);
  const std::vector<Int3> own_near = triangles_near(pair.own, own_x, other_x, far),
                          other_near = triangles_near(other, other_x, own_x, far);
  if (own_near.empty() || other_near.empty()) return {};
  const std::array<contact::PairSurface, 2> surfaces{
      {{pair.index, pair.own.rest, own_x, own_near, {}}, {pair.other, other.rest, other_x, other_near, {}}}};
  return contact::find_node_sites(exec, nodes, surfaces, params, contact.sites);
}

/// Predicted displacements of the other ends of the springs of an attachment.
std::vector<Vec3d> ends_ahead(const World& world, const Attachment& attachment) {
  std::vector<Vec3d> ends;
  std::vector<Vec3d> displacement;
  for (const contact::Tie& tie : attachment.ties) {
    const contact::SurfacePoint& end = attachment.swept == 0 ? tie.b : tie.a;
    if (end.body >= first_support(world) && displacement.empty())
      displacement = support_displacement(world, swept_support(world, end.body));
    const Vec3d moved = displacement.empty() ? Vec3d{} : contact::displacement_of(end, displacement);
    ends.push_back(moved + motion_ahead(world, end));
  }
  return ends;
}

/// Stiffness with which a swept lattice resists a displacement of its contact: that of the nodes that bear,
/// at most the inertia of a body that nothing fixes [N/m].
double at_most_inertia(const World& world, const CoupledSupport& support, double stiffness) {
  const double square = world.dt * world.dt;
  return support.free_mass > 0 ? std::min(stiffness, support.free_mass / square) : stiffness;
}

/// Adds a force on a point of a body, by vertex.
void add_force_at(const contact::SurfacePoint& point, Vec3d force, int index,
                  std::vector<contact::VertexForce>& forces) {
  if (point.body != index || force == Vec3d{}) return;
  for (int corner = 0; corner < 3; corner++)
    if (point.vertex[corner] >= 0 && point.weight[corner] != 0)
      forces.push_back({point.vertex[corner], force * point.weight[corner]});
}

}  // namespace

Vec3d motion_ahead(const World& world, const contact::SurfacePoint& point) {
  if (point.body < first_support(world)) return {};
  const CoupledSupport& support = swept_support(world, point.body);
  if (support.body.kind != BodyKind::kLattice) return {};
  const LatticeBody& body = lattice_of(world, support);
  const lattice::Motion& motion = body.state->motion;
  Vec3d velocity;
  for (int corner = 0; corner < 3; corner++)
    if (const int v = point.vertex[corner]; v >= 0)
      velocity += vertex_velocity(support, v, motion) * point.weight[corner];
  return patient_axes(body) * (velocity * world.dt);
}

int swept_side(const World& world, BodyId body, const std::optional<BodyId>& other) {
  if (body.kind == BodyKind::kCloth) return 0;
  if (other && other->kind == BodyKind::kCloth) return 1;
  const auto yields = [&](BodyId id) {
    return id.kind == BodyKind::kSfem ||
           (id.kind == BodyKind::kRigid && !world.rigid_bodies[std::size_t(id.index)].model.is_fixed);
  };
  if (yields(body) || (other && yields(*other))) return -1;
  if (body.kind != BodyKind::kLattice) return other && other->kind == BodyKind::kLattice ? 1 : -1;
  if (!other || other->kind != BodyKind::kLattice) return 0;
  const auto mass = [&](BodyId id) { return swept_support(world, coupled_index(world, id)).free_mass; };
  const double own = mass(body), others = mass(*other);
  if (own == 0 || others == 0) return own == 0 && others > 0 ? 1 : 0;
  return others < own ? 1 : 0;
}

SweptNodes swept_nodes(const LatticeBody& body, const CoupledSupport& support) {
  SweptNodes nodes;
  if (!support.cell.empty()) {
    // outermost nodes of partial cells are not at the surface: its vertices touch
    for (const Int3 t : support.triangles) nodes.vertex.insert(nodes.vertex.end(), {t.x, t.y, t.z});
    sort_unique(nodes.vertex);
    for (const int vertex : nodes.vertex) {
      const auto v = std::size_t(vertex);
      nodes.slot.push_back(support.carrier[v]), nodes.rest.push_back(support.rest[v]);
      nodes.cell.push_back(support.cell[v]);
    }
    return nodes;
  }
  // samples of the skin at its nodes
  const contact::LatticeTouch touch = contact::make_lattice_touch(body.model, body.state.cuts(), body.surface,
                                                                  {}, contact::TouchCarrier::kNodes);
  const TriangleTree tree = build_triangle_tree(support.rest, support.triangles);
  const Grid& grid = body.model.anatomy.grid;
  for (const contact::LatticeSample& sample : touch.samples) {
    if (sample.wall || sample.other >= 0) continue;
    const Vec3d rest = grid.origin + grid.axes * sample.rest;
    // nearest vertex of the surface
    const TrianglePoint near = nearest_point(tree, rest);
    const Vec3d w = near.weights;
    const Int3 t = support.triangles[std::size_t(near.triangle)];
    nodes.slot.push_back(sample.slot), nodes.rest.push_back(rest);
    nodes.vertex.push_back(w.x >= w.y && w.x >= w.z ? t.x : w.y >= w.z ? t.y : t.z);
  }
  return nodes;
}

double free_mass(const LatticeBody& body) {
  const lattice::Anatomy& anatomy = body.model.anatomy;
  return anatomy.free_nodes < anatomy.body_nodes ? 0 : lattice::moving_mass(anatomy);
}

double farthest_ahead(const World& world, const CoupledSupport& support) {
  const double fall = world.dt * world.dt * norm(world.gravity);
  return support.body.kind == BodyKind::kLattice ? lattice_of(world, support).last_displacement + fall : fall;
}

std::vector<double> swept_rest_heights(const Exec& exec, const World& world, const BodyContact& contact) {
  const SweptPair pair = swept_pair(world, contact);
  const SweptNodes& own = pair.own.nodes;
  const CoupledSupport& other = swept_support(world, pair.other);
  const std::array<contact::PairSurface, 2> surfaces{
      {{pair.index, pair.own.rest, pair.own.rest, pair.own.triangles, {}},
       {pair.other, other.rest, other.rest, other.triangles, {}}}};
  return contact::rest_heights(exec, {own.rest, own.rest, own.vertex, {}}, surfaces, contact.params);
}

SweptContacts::SweptContacts(const LatticeBody& body, World& world, const SweptForces& springs)
    : body_(body), springs_(springs) {
  const Mat3d to_lattice = transposed(patient_axes(body));
  for (BodyContact& contact : world.coupling.contacts) {
    if (contact.swept < 0 || !is_swept_by(world, body, contact.body[std::size_t(contact.swept)])) continue;
    const lattice::Motion& motion = body.state->motion;  // downloads the motion of a body on a GPU
    const CoupledSupport& own = swept_pair(world, contact).own;
    springs_.free_mass = own.free_mass;
    for (contact::PairSite& site : contact.sites) {
      // the other body has moved by `ahead` when the step ends
      const auto n = std::size_t(site.node);
      const Vec3d u = node_displacement(own.nodes, n, motion);
      int slot = own.nodes.slot[n];
      if (!own.nodes.cell.empty()) {
        slot = leading_corner({body.model, {}}, own.nodes.cell[n]);
        if (slot < 0) continue;
        own_points_.at.push_back(own.nodes.cell[n]), own_points_.leader.push_back(slot);
      }
      own_.push_back({.slot = slot,
                      .normal = Vec3(to_lattice * site.normal),
                      .target = Vec3(u + to_lattice * (site.ahead - site.normal * site.distance)),
                      .friction = Real(site.friction),
                      .force = Vec3(to_lattice * site.force)});
      sites_.push_back({slot, &site});
    }
  }
  if (!own_points_.at.empty()) return;
  const auto first = [](const auto& a, const auto& b) { return a.slot < b.slot; };
  std::stable_sort(own_.begin(), own_.end(), first);
  std::stable_sort(sites_.begin(), sites_.end(), first);
}

/// Acceleration with which the sweeps start, by the contacts and springs of the last step.
Vec3d SweptContacts::start(const lattice::Inputs& inputs, double dt) const {
  SweptForces forces = springs_;
  if (forces.free_mass == 0) return {};
  Vec3d of_contacts;
  for (std::size_t c = 0; c < own_.size(); c++) {
    const Vec3d normal(own_[c].normal), force(own_[c].force);
    const double pressed = dot(normal, force);
    forces.add(normal * pressed, transposed(patient_axes(body_)) * sites_[c].site->ahead);
    forces.friction += double(own_[c].friction) * pressed;
    of_contacts += force;
  }
  // forces of tools, and of bodies, which are among the contacts
  Vec3d all;
  for (const lattice::NodeContact& contact : inputs.contacts) {
    if (contact.is_held) return {};
    all += Vec3d(contact.force);
  }
  return start_acceleration(body_, forces, all - of_contacts, inputs.gravity, dt);
}

void SweptContacts::join(lattice::Inputs& inputs, double dt) {
  if (own_.empty() && springs_.magnitudes > 0) inputs.start_acceleration = start(inputs, dt);
  if (own_.empty()) return;
  joined_.clear(), origins_.clear();
  auto next = own_.begin();
  const auto add = [&](lattice::NodeContact& contact) {
    joined_.push_back(contact), origins_.push_back(&contact);
  };
  const bool in_cells = !own_points_.at.empty();
  TURGOR_CHECK(in_cells ? inputs.points || inputs.contacts.empty() : inputs.points == nullptr,
               "contacts of tools and of bodies act in cells, or on nodes");
  for (lattice::NodeContact& of_tool : inputs.contacts) {
    for (; !in_cells && next != own_.end() && next->slot < of_tool.slot; ++next) add(*next);
    add(of_tool);
  }
  for (; next != own_.end(); ++next) add(*next);
  if (in_cells) {
    points_ = inputs.points ? *inputs.points : lattice::ContactPoints{};
    points_.at.insert(points_.at.end(), own_points_.at.begin(), own_points_.at.end());
    points_.leader.insert(points_.leader.end(), own_points_.leader.begin(), own_points_.leader.end());
    make_terms({body_.model, body_.touch.virtual_slots}, points_);
    inputs.points = &points_;
  }
  inputs.contacts = joined_;
  inputs.start_acceleration = start(inputs, dt);
}

void SweptContacts::finish() {
  if (own_.empty()) return;
  for (std::size_t c = 0; c < joined_.size(); c++) *origins_[c] = joined_[c];
  for (std::size_t c = 0; c < own_.size(); c++) {
    const Vec3d force(own_[c].force);
    contact::PairSite& site = *sites_[c].site;
    site.force = patient_axes(body_) * force;
    const double pressed = dot(Vec3d(own_[c].normal), force);
    const double across = norm(force - Vec3d(own_[c].normal) * pressed);
    site.state = !(pressed > 0)                                  ? contact::SiteState::kOpen
                 : across < site.friction * pressed * (1 - 1e-4) ? contact::SiteState::kStick
                                                                 : contact::SiteState::kSlip;
  }
}

void find_swept(const Exec& exec, World& world) {
  for (BodyContact& contact : world.coupling.contacts) {
    if (contact.swept < 0) continue;
    contact::PairSites found = swept_sites(exec, world, contact);
    const SweptPair pair = swept_pair(world, contact);
    const lattice::Cuts& cuts = lattice_of(world, pair.own).state.cuts();
    std::erase_if(found.sites, [&](const contact::PairSite& site) {
      return cuts.removed[std::size_t(pair.own.nodes.slot[std::size_t(site.node)])] != 0;
    });
    if (pair.other >= 0) contact::permit_depth(contact.sites, world.dt, found.sites);
    for (contact::PairSite& site : found.sites) site.ahead = motion_ahead(world, site.b);
    contact.sites = std::move(found.sites);
    contact.deepest = std::max(contact.deepest, found.deepest);
  }
  for (Attachment& attachment : world.coupling.attachments)
    if (is_swept_by_lattice(world, attachment)) attachment.ahead = ends_ahead(world, attachment);
}

std::vector<contact::VertexForce> swept_forces_on(const World& world, int index) {
  std::vector<contact::VertexForce> forces;
  for (const BodyContact& contact : world.coupling.contacts)
    if (contact.swept >= 0)
      for (const contact::PairSite& site : contact.sites) add_force_at(site.b, -site.force, index, forces);
  for (const Attachment& attachment : world.coupling.attachments)
    for (const contact::Tie& tie : attachment.ties) {
      if (attachment.swept == 0) add_force_at(tie.b, -tie.force, index, forces);
      if (attachment.swept == 1) add_force_at(tie.a, tie.force, index, forces);
    }
  return forces;
}

double swept_stiffness_on(const World& world, int index) {
  double sum = 0;
  for (const BodyContact& contact : world.coupling.contacts) {
    if (contact.swept < 0 || swept_pair(world, contact).other != index) continue;
    const CoupledSupport& own = swept_pair(world, contact).own;
    double of_nodes = 0;
    for (const contact::PairSite& site : contact.sites)
      if (site.force != Vec3d{}) of_nodes += 1 / node_softness(world, own, site.a.vertex.x);
    sum += at_most_inertia(world, own, of_nodes);
  }
  for (const Attachment& attachment : world.coupling.attachments) {
    if (attachment.swept < 0 || attachment.ties.empty()) continue;
    const contact::Tie& tie = attachment.ties[0];
    const int own = attachment.swept == 0 ? tie.a.body : tie.b.body;
    const int other = attachment.swept == 0 ? tie.b.body : tie.a.body;
    if (other == index) sum += at_most_inertia(world, swept_support(world, own), attachment.stiffness);
  }
  return sum;
}

}  // namespace turgor

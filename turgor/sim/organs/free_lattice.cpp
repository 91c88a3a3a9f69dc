#include "turgor/sim/organs/free_lattice.hpp"

#include <algorithm>

#include "turgor/models/lattice/model/whole_motion.hpp"
#include "turgor/sim/organs/swept_body.hpp"

namespace turgor {

namespace {

/// Number of a lattice in contacts and attachments; -1 if it is in none.
int index_of(const World& world, const LatticeBody& body) {
  const std::vector<CoupledSupport>& supports = world.coupling.supports;
  for (std::size_t n = 0; n < supports.size(); n++)
    if (supports[n].body.kind == BodyKind::kLattice && &lattice_of(world, supports[n]) == &body)
      return first_support(world) + int(n);
  return -1;
}

const CoupledSupport* lattice_support(const World& world, int index) {
  if (index < first_support(world)) return nullptr;
  const CoupledSupport& support = swept_support(world, index);
  return support.body.kind == BodyKind::kLattice ? &support : nullptr;
}

bool is_tied(const World& world, int index, bool swept_only) {
  const auto ties = [&](const Attachment& attachment) {
    return !attachment.ties.empty() && (attachment.swept >= 0 || !swept_only) &&
           (attachment.ties[0].a.body == index || attachment.ties[0].b.body == index);
  };
  return std::any_of(world.coupling.attachments.begin(), world.coupling.attachments.end(), ties);
}

bool is_sewn(const World& world, const CoupledSupport& support) {
  return std::any_of(world.sutures.begin(), world.sutures.end(),
                     [&](const Suture& suture) { return suture.scene.body == support.body.index; });
}

/// True for a lattice on the host that nothing fixes.
bool is_free(const World& world, const CoupledSupport& support) {
  const LatticeBody& body = lattice_of(world, support);
  return support.free_mass > 0 && !body.state.has_device() &&
         body.model.params.solver.method == lattice::Method::kVbd;
}
bool has_tools(const World& world, const CoupledSupport& support) {
  return !lattice_of(world, support).tools.empty();
}
bool has_needle(const World& world, const CoupledSupport& support) {
  const std::vector<contact::Tool>& tools = lattice_of(world, support).tools;
  return std::any_of(tools.begin(), tools.end(), [](const contact::Tool& tool) { return !!tool.needle; });
}

bool bears_cloth(const World& world, const CoupledSupport& support) {
  for (const ClothBody& cloth : world.cloth_bodies)
    for (const ClothObstacle& obstacle : cloth.obstacles)
      if (obstacle.support && obstacle.support->body == support.body) return true;
  return false;
}

/// The only contact of a free lattice that is solved in its sweeps, if nothing else holds it; else null.
const BodyContact* only_contact(const World& world, int index) {
  const CoupledSupport& support = swept_support(world, index);
  if (!is_free(world, support) || has_tools(world, support) || is_tied(world, index, false) ||
      is_sewn(world, support))
    return nullptr;
  const BodyContact* only = nullptr;
  for (const BodyContact& contact : world.coupling.contacts) {
    if (contact.swept < 0 || contact.body[std::size_t(contact.swept)] != index) continue;
    if (only) return nullptr;
    only = &contact;
  }
  return only;
}

}  // namespace

bool moves_whole(const World& world, const CoupledSupport& support) {
  if (support.body.kind != BodyKind::kLattice || !is_free(world, support) || has_needle(world, support))
    return false;
  const int index = coupled_index(world, support.body);
  for (const BodyContact& contact : world.coupling.contacts)
    if (contact.swept >= 0 && (contact.body[0] == index || contact.body[1] == index)) return false;
  return !is_tied(world, index, true) && !bears_cloth(world, support);
}

bool is_among_free_lattices(const World& world, const LatticeBody& body) {
  std::vector<int> found{index_of(world, body)};
  for (std::size_t n = 0; n < found.size(); n++) {
    const CoupledSupport* support = lattice_support(world, found[n]);
    if (!support || !is_free(world, *support) || has_tools(world, *support)) return false;
    if (is_tied(world, found[n], false) || is_sewn(world, *support)) return false;
    // bodies whose contacts are solved in sweeps; the forces of others are loads
    for (const BodyContact& contact : world.coupling.contacts)
      for (std::size_t side = 0; side < 2; side++)
        if (const int other = contact.body[1 - side];
            contact.swept >= 0 && contact.body[side] == found[n] &&
            std::find(found.begin(), found.end(), other) == found.end())
          found.push_back(other);
  }
  return true;
}

contact::SupportInertia move_ahead(const World& world, const CoupledSupport& support,
                                   const std::vector<Vec3d>& x, std::vector<Vec3d>& displacement) {
  const LatticeBody& body = lattice_of(world, support);
  const Grid& grid = body.model.anatomy.grid;
  const double h = world.dt;
  const lattice::WholeMotion whole = lattice::whole_motion(body.model, *body.state);
  const Vec3d center = grid.origin + grid.axes * whole.center;
  // forces of tools in the last step
  Vec3d force, torque;
  for (const lattice::NodeContact& contact : body.touch.nodes) {
    const Vec3d f(contact.force);
    force += f;
    torque += cross(lattice::node_position(body.model, *body.state, contact.slot) - whole.center, f);
  }
  // motion without forces of the coupling
  const Vec3d fall = body.has_gravity ? world.gravity * (h * h) : Vec3d{};
  const Vec3d shift = grid.axes * (whole.velocity * h + force * (h * h / whole.mass)) + fall;
  const Vec3d turn = grid.axes * (whole.spin * h + whole.inverse_inertia * torque * (h * h));
  for (std::size_t v = 0; v < x.size(); v++) displacement[v] += shift + cross(turn, x[v] - center);
  // inertia
  contact::SupportInertia inertia{.center = center + shift, .translation = h * h / whole.mass};
  inertia.rotation = grid.axes * whole.inverse_inertia * transposed(grid.axes);
  for (Vec3d& column : inertia.rotation.column) column *= h * h;
  return inertia;
}

void set_free_motion(const World& world, const LatticeBody& body, lattice::Inputs& inputs) {
  const int index = index_of(world, body);
  if (index < 0) return;
  const CoupledSupport& support = swept_support(world, index);
  inputs.balances_momentum = is_among_free_lattices(world, body);
  inputs.measures_balance = !inputs.balances_momentum && only_contact(world, index);
  if (moves_whole(world, support))
    inputs.start_acceleration = transposed(patient_axes(body)) * total_force(body.cloth) / support.free_mass;
}

void record_balance(World& world, const LatticeBody& body, const lattice::StepReport& done) {
  const int index = index_of(world, body);
  const BodyContact* only = index < 0 ? nullptr : only_contact(world, index);
  for (BodyContact& contact : world.coupling.contacts)
    if (&contact == only) contact.unbalanced = done.finite ? patient_axes(body) * done.unbalanced : Vec3d{};
}

}  // namespace turgor

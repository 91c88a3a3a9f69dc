// Lattices, bodies of chains and cloth as supports: their numbers, their surfaces, and where these are.
#include <algorithm>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Cell of every vertex of a surface without cuts. A corner without a node has the nearest one.
std::vector<lattice::EmbeddedPoint> cells_of_vertices(const LatticeBody& body) {
  const lattice::BodySurface& surface = body.surface;
  const Lattice& l = body.model.anatomy.lattice;
  std::vector<lattice::EmbeddedPoint> cells;
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const int cell = surface.embedding[v].cell;
    const Vec3d rest(surface.rest[v]);
    const Vec3d at{rest.x / l.spacing.x, rest.y / l.spacing.y, rest.z / l.spacing.z - l.first};
    lattice::EmbeddedPoint point{
        .cell = cell,
        .corner = lattice::corners_of(body.model, *surface.fragments, cell, surface.embedding[v].fragment),
        .weight = lattice::trilinear(Vec3(at - Vec3d(slot_node(l, cell))))};
    for (int& corner : point.corner)
      if (!has_node(body.model, corner)) corner = surface.slot[v];
    cells.push_back(point);
  }
  return cells;
}

/// Surface of a lattice, of chains or of cloth for attachments and contacts.
CoupledSupport make_support(const Exec& exec, BodyId id, World& world) {
  CoupledSupport support{
      .body = id, .rest = {}, .carrier = {}, .triangles = {}, .force = {}, .solved = {}, .nodes = {}};
  if (id.kind == BodyKind::kLattice) {
    LatticeBody& body = world.lattice_bodies[std::size_t(id.index)];
    refresh_surface(exec, body);
    support.rest = body.rest, support.carrier = body.surface.slot;
    support.triangles = body.surface.triangles, support.free_mass = free_mass(body);
    if (!body.model.anatomy.cell_center.empty()) support.cell = cells_of_vertices(body);
    return support;
  }
  if (id.kind == BodyKind::kCloth) {
    const ClothBody& body = world.cloth_bodies[std::size_t(id.index)];
    support.carrier = body.model.model_vertex, support.triangles = body.triangles;
    for (const int v : support.carrier) support.rest.emplace_back(body.state->x[std::size_t(v)]);
    return support;
  }
  const rhombus::Surface& surface = world.rhombus_bodies[std::size_t(id.index)].model.surface;
  support.rest = surface.vertices, support.triangles = surface.triangles;
  support.carrier.resize(support.rest.size());
  std::iota(support.carrier.begin(), support.carrier.end(), 0);
  return support;
}

/// Adds a support for a lattice, chains or cloth that has none.
void add_support(const Exec& exec, BodyId id, World& world) {
  if (id.kind == BodyKind::kSfem || id.kind == BodyKind::kRigid) return;
  for (const CoupledSupport& support : world.coupling.supports)
    if (support.body == id) return;
  world.coupling.supports.push_back(make_support(exec, id, world));
}

}  // namespace

int coupled_index(const World& world, BodyId id) {
  if (id.kind == BodyKind::kSfem) return id.index;
  if (id.kind == BodyKind::kRigid) return int(world.sfem_bodies.size()) + id.index;
  const std::vector<CoupledSupport>& supports = world.coupling.supports;
  const auto found = std::find_if(supports.begin(), supports.end(),
                                  [id](const CoupledSupport& support) { return support.body == id; });
  TURGOR_ASSERT(found != supports.end(), "loading makes the supports of attachments and contacts");
  return first_support(world) + int(found - supports.begin());
}

BodyId coupled_body(const World& world, int index) {
  const int sfem = int(world.sfem_bodies.size()), support = first_support(world);
  if (index < sfem) return {BodyKind::kSfem, index};
  if (index < support) return {BodyKind::kRigid, index - sfem};
  return world.coupling.supports[std::size_t(index - support)].body;
}

std::vector<Vec3d> support_displacement(const World& world, const CoupledSupport& support) {
  std::vector<Vec3d> displacement;
  displacement.reserve(support.carrier.size());
  const auto index = std::size_t(support.body.index);
  if (support.body.kind == BodyKind::kLattice) {
    const LatticeBody& body = world.lattice_bodies[index];
    const Mat3d& axes = body.model.anatomy.grid.axes;
    const lattice::Motion& motion = body.state->motion;
    for (const lattice::EmbeddedPoint& cell : support.cell)
      displacement.push_back(axes * Vec3d(lattice::displacement(cell, motion)));
    if (!support.cell.empty()) return displacement;
    for (const int slot : support.carrier) displacement.push_back(axes * Vec3d(motion.u[std::size_t(slot)]));
  } else if (support.body.kind == BodyKind::kCloth) {
    const cloth::Vectors& x = world.cloth_bodies[index].state->x;
    for (std::size_t v = 0; v < support.carrier.size(); v++)
      displacement.push_back(Vec3d(x[std::size_t(support.carrier[v])]) - support.rest[v]);
  } else {
    const rhombus::State& state = world.rhombus_bodies[index].state;
    for (const int v : support.carrier) displacement.push_back(state.displacement[std::size_t(v)]);
  }
  return displacement;
}

void add_supports(const Exec& exec, const Scene& scene, World& world) {
  for (const AttachmentScene& attachment : scene.attachments) {
    add_support(exec, attachment.body, world);
    if (attachment.other) add_support(exec, *attachment.other, world);
  }
  for (const BodyContactScene& contact : scene.body_contacts) {
    add_support(exec, contact.body, world);
    if (contact.other) add_support(exec, *contact.other, world);
  }
}

}  // namespace turgor

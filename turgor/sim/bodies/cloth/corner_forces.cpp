#include "turgor/sim/bodies/cloth/corner_forces.hpp"

#include <array>
#include <utility>

#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Adds the force on a vertex to the corners of its cell. A corner without a node has the nearest one.
void add_to_corners(const LatticeBody& body, const contact::VertexForce& on_vertex,
                    std::vector<contact::VertexForce>& forces) {
  // corners and weights
  const lattice::BodySurface& surface = body.surface;
  const Lattice& l = body.model.anatomy.lattice;
  const auto vertex = std::size_t(on_vertex.vertex);
  const lattice::EmbeddingCell embedding = surface.embedding[vertex];
  const std::array<int, 8> corner =
      lattice::corners_of(body.model, *surface.fragments, embedding.cell, embedding.fragment);
  const Vec3d rest(surface.rest[vertex]);
  const Vec3d at{rest.x / l.spacing.x, rest.y / l.spacing.y, rest.z / l.spacing.z - l.first};
  const std::array<Real, 8> weight = lattice::trilinear(Vec3(at - Vec3d(slot_node(l, embedding.cell))));
  // shares
  const auto slots = int(body.model.anatomy.inverse_mass.size());
  for (std::size_t c = 0; c < 8; c++) {
    if (weight[c] == 0) continue;
    const int slot =
        corner[c] < slots ? corner[c] : surface.fragments->virtual_nodes[std::size_t(corner[c] - slots)].slot;
    forces.push_back(
        {has_node(body.model, slot) ? slot : surface.slot[vertex], on_vertex.force * double(weight[c])});
  }
}

}  // namespace

void move_to_corners(const World& world, ClothSupport& support) {
  if (support.body.kind != BodyKind::kLattice) return;
  const LatticeBody& body = world.lattice_bodies[std::size_t(support.body.index)];
  if (body.model.anatomy.cell_center.empty()) return;
  TURGOR_CHECK(body.surface.rest.size() == support.carrier.size(), "forces act on the surface of the frame");
  std::vector<contact::VertexForce> forces;
  for (const contact::VertexForce& on_vertex : support.force) add_to_corners(body, on_vertex, forces);
  support.force = std::move(forces);
}

}  // namespace turgor

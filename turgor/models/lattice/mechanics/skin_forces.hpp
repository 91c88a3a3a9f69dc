// Skin forces and Hessians at nodes of a row, for many triangle corners at once. The laws are in
// element_energies.hpp.
#pragma once

#include <algorithm>
#include <span>

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

using CornerSystems = Systems<kSkinLanes>;

/// Forces on the corners of triangles, by corner and axis [N].
struct TriangleForces {
  alignas(64) Real on[3][3][kSkinLanes];

  Vec3 get(int corner, int i) const { return {on[corner][0][i], on[corner][1][i], on[corner][2][i]}; }
};

struct SkinForces {
  SkinLaw law;
  FiberLaw fiber;
  Real rest_ratio, stiffness, amplification;

  explicit SkinForces(const Model& model)
      : law(model.params.skin.law),
        fiber(fiber_law(model.params.skin)),
        rest_ratio(rest_area_ratio(model.params.skin)),
        stiffness(Real(model.params.skin.stiffness)),
        amplification(Real(model.params.skin.amplification)) {}

  /// System of a corner at its own node; the edges start there.
  TURGOR_HD NodeSystem fiber_system(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    add_skin_fiber(s, edge1, edge2, {c.along[0][i], c.along[1][i], c.along[2][i]},
                   {c.across[0][i], c.across[1][i], c.across[2][i]}, c.area[i], fiber);
    return s;
  }
  TURGOR_HD NodeSystem area_system(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    const Real rest = rest_ratio * c.area[i];
    add_skin_area(s, {}, edge1, edge2, rest, stiffness / rest, amplification);
    return s;
  }
  /// System of one corner.
  TURGOR_HD NodeSystem gather(const SkinCorners& c, int i, const NodeArrays& n) const {
    const Vec3 u0 = n.u(c.vertex[0][i]);
    const auto edge = [&](int q) {
      return Vec3{c.edge[q - 1][0][i], c.edge[q - 1][1][i], c.edge[q - 1][2][i]} + (n.u(c.vertex[q][i]) - u0);
    };
    return law == SkinLaw::kFiber ? fiber_system(c, i, edge(1), edge(2))
                                  : area_system(c, i, edge(1), edge(2));
  }
  /// Systems of all corners of a batch.
  void gather(const SkinCorners& corners, const NodeArrays& nodes, CornerSystems& out) const;
  /// Forces on all corners of at most kSkinLanes triangles, without Hessians.
  void compute_forces(std::span<const SkinTriangle> triangles, const NodeArrays& nodes,
                      TriangleForces& out) const;
};

/// Adds skin and prestress at the nodes of [slot, slot + count): store(node, load(node) + system).
template <class Load, class Store>
void for_skin_nodes(const Model& model, const Cuts& cuts, const NodeArrays& n, const SkinForces& forces,
                    int slot, int count, const Load& load, const Store& store) {
  const Skin& skin = model.skin;
  const auto row = std::size_t(slot / model.lattice.half);
  // first skin node of the range
  const int *nodes = skin.nodes.data(), *end = nodes + skin.row_begin[row + 1];
  const int* node = std::lower_bound(nodes + skin.row_begin[row], end, slot);
  if (node == end || *node >= slot + count) return;
  const int first = skin.corner_begin[std::size_t(skin.row_begin[row])];
  CornerSystems systems;
  int gathered = -1;  // index of the batch in `systems`
  for (; node != end && *node < slot + count; node++) {
    const auto at = std::size_t(node - nodes);
    // prestress
    NodeSystem s = load(*node);
    s.f -= skin.prestress_force[at];
    // triangles around the node
    for (int c = skin.corner_begin[at]; c < skin.corner_begin[at + 1]; c++) {
      const int lanes = skin.lanes_begin[row] + (c - first) / kSkinLanes, lane = (c - first) % kSkinLanes;
      const SkinCorners& corners = skin.corners[std::size_t(lanes)];
      if (lanes != gathered) forces.gather(corners, n, systems), gathered = lanes;
      if (!cuts.skin_cut[std::size_t(corners.triangle[lane])]) add(s, systems.get(lane));
    }
    store(*node, s);
  }
}

}  // namespace turgor::lattice

// What skin asks of the nodes of a row, by the law of the model: many corners of triangles at once.
#pragma once

#include <algorithm>
#include <span>

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

using CornerSystems = Systems<kSkinLanes>;

/// On the corners of triangles, by corner and axis [N].
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

  /// What a corner asks of its own node, from which the edges lead.
  TURGOR_HD NodeSystem of_fibers(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    add_skin_fiber(s, edge1, edge2, {c.along[0][i], c.along[1][i], c.along[2][i]},
                   {c.across[0][i], c.across[1][i], c.across[2][i]}, c.area[i], fiber);
    return s;
  }
  TURGOR_HD NodeSystem of_area(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    const Real rest = rest_ratio * c.area[i];
    add_skin_area(s, {}, edge1, edge2, rest, stiffness / rest, amplification);
    return s;
  }
  /// One of them.
  TURGOR_HD NodeSystem gather(const SkinCorners& c, int i, const NodeArrays& n) const {
    const Vec3 here = n.u(c.vertex[0][i]);
    const auto edge = [&](int q) {
      return Vec3{c.edge[q - 1][0][i], c.edge[q - 1][1][i], c.edge[q - 1][2][i]} +
             (n.u(c.vertex[q][i]) - here);
    };
    return law == SkinLaw::kFiber ? of_fibers(c, i, edge(1), edge(2)) : of_area(c, i, edge(1), edge(2));
  }
  /// What each of these corners asks of its own node.
  void gather(const SkinCorners& corners, const NodeArrays& nodes, CornerSystems& out) const;
  /// Forces alone, on all corners of at most kSkinLanes triangles.
  void find(std::span<const SkinTriangle> triangles, const NodeArrays& nodes, TriangleForces& out) const;
};

/// Adds what the skin around the nodes of [slot, slot + count) asks of them: store(node, load(node) + that).
template <class Load, class Store>
void for_skin_nodes(const Model& model, const State& state, const NodeArrays& n, const SkinForces& forces,
                    int slot, int count, const Load& load, const Store& store) {
  const Skin& skin = model.skin;
  const auto row = std::size_t(slot / model.lattice.half);
  const int *nodes = skin.nodes.data(), *end = nodes + skin.row_begin[row + 1];
  const int* node = std::lower_bound(nodes + skin.row_begin[row], end, slot);
  if (node == end || *node >= slot + count) return;
  const int first = skin.corner_begin[std::size_t(skin.row_begin[row])];
  CornerSystems systems;
  int gathered = -1;  // which lanes
  for (; node != end && *node < slot + count; node++) {
    const auto at = std::size_t(node - nodes);
    NodeSystem s = load(*node);
    s.f -= skin.pull[at];
    for (int c = skin.corner_begin[at]; c < skin.corner_begin[at + 1]; c++) {
      const int lanes = skin.lanes_begin[row] + (c - first) / kSkinLanes, lane = (c - first) % kSkinLanes;
      const SkinCorners& corners = skin.corners[std::size_t(lanes)];
      if (lanes != gathered) forces.gather(corners, n, systems), gathered = lanes;
      if (!state.skin_cut[std::size_t(corners.triangle[lane])]) add(s, systems.get(lane));
    }
    store(*node, s);
  }
}

}  // namespace turgor::lattice

// Skin forces and Hessians at nodes of a row, for many triangle corners at once. The laws are in
// element_energies.hpp and skin_exponential.hpp.
#pragma once

#include <algorithm>
#include <span>

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"
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
  ExponentialSkin exponential;

  explicit SkinForces(const Model& model)
      : law(model.params.skin.law),
        fiber(fiber_law(model.params.skin)),
        rest_ratio(rest_area_ratio(model.params.skin)),
        stiffness(Real(model.params.skin.stiffness)),
        amplification(Real(model.params.skin.amplification)),
        exponential(exponential_skin(model.params.skin)) {}

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
  TURGOR_HD NodeSystem exponential_system(const SkinCorners& c, int i, Vec3 edge1, Vec3 edge2) const {
    NodeSystem s;
    add_skin_exponential(s, edge1, edge2, {c.along[0][i], c.along[1][i], c.along[2][i]},
                         {c.across[0][i], c.across[1][i], c.across[2][i]}, c.area[i], exponential);
    return s;
  }
  /// System of one corner.
  TURGOR_HD NodeSystem gather(const SkinCorners& c, int i, const NodeArrays& n) const {
    const Vec3 u0 = n.u(c.vertex[0][i]);
    const auto edge = [&](int q) {
      return Vec3{c.edge[q - 1][0][i], c.edge[q - 1][1][i], c.edge[q - 1][2][i]} + (n.u(c.vertex[q][i]) - u0);
    };
    if (law == SkinLaw::kExponential) return exponential_system(c, i, edge(1), edge(2));
    return law == SkinLaw::kFiber ? fiber_system(c, i, edge(1), edge(2))
                                  : area_system(c, i, edge(1), edge(2));
  }
  /// Systems of all corners of a batch.
  void gather(const SkinCorners& corners, const NodeArrays& nodes, CornerSystems& out) const;
  /// Forces on all corners of at most kSkinLanes triangles, without Hessians.
  void compute_forces(std::span<const SkinTriangle> triangles, const NodeArrays& nodes,
                      TriangleForces& out) const;
};

/// Corners of skin by node, as plain pointers for host and device (Skin, VbdTables, Cuts::skin_cut).
struct SkinView {
  const int *nodes, *corner_begin, *row_begin, *lanes_begin;  // null without skin
  const Vec3* prestress_force;
  const SkinCorners* corners;
  const std::uint8_t* skin_cut;  // by triangle
};
inline SkinView skin_view(const Model& model, const Cuts& cuts) {
  const Skin& skin = model.anatomy.skin;
  const VbdTables& vbd = model.vbd;
  return {skin.nodes.data(),      vbd.corner_begin.data(),      skin.row_begin.data(),
          vbd.lanes_begin.data(), model.prestress_force.data(), vbd.corners.data(),
          cuts.skin_cut.data()};
}

/// Adds prestress and the uncut triangles of skin node `at` of a half row. `system_of(batch, lane)`: system
/// of a corner.
template <class SystemOf>
TURGOR_HD inline void add_skin_corners(const SkinView& v, int row, int at, NodeSystem& s,
                                       const SystemOf& system_of) {
  s.f -= v.prestress_force[at];
  const int first = v.corner_begin[v.row_begin[row]];
  for (int c = v.corner_begin[at]; c < v.corner_begin[at + 1]; c++) {
    const int batch = v.lanes_begin[row] + (c - first) / kSkinLanes, lane = (c - first) % kSkinLanes;
    if (!v.skin_cut[v.corners[batch].triangle[lane]]) add(s, system_of(batch, lane));
  }
}

/// Adds skin and prestress at the nodes of [slot, slot + count): store(node, load(node) + system).
template <class Load, class Store>
void for_skin_nodes(const Model& model, const Cuts& cuts, const NodeArrays& n, const SkinForces& forces,
                    int slot, int count, const Load& load, const Store& store) {
  const SkinView skin = skin_view(model, cuts);
  const int row = slot / model.anatomy.lattice.half;
  CornerSystems systems;
  int gathered = -1;  // index of the batch in `systems`
  const int* end = skin.nodes + skin.row_begin[row + 1];
  const int* node = std::lower_bound(skin.nodes + skin.row_begin[row], end, slot);
  for (; node != end && *node < slot + count; node++) {
    NodeSystem s = load(*node);
    add_skin_corners(skin, row, int(node - skin.nodes), s, [&](int batch, int lane) {
      if (batch != gathered) forces.gather(skin.corners[batch], n, systems), gathered = batch;
      return systems.get(lane);
    });
    store(*node, s);
  }
}

}  // namespace turgor::lattice

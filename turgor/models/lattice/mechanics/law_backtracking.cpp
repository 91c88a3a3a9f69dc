#include "turgor/models/lattice/mechanics/law_backtracking.hpp"

namespace turgor::lattice {

namespace {

/// Whole uncut cells around a node.
struct CellsOfNode {
  const Model& model;
  const State& state;
  const CellLawView& laws;
  Int3 node;

  /// Calls visit(cell slot, corner of the node, displacements) for each cell, with the node moved by `more`.
  template <class Visit>
  void for_each(Vec3d more, const Visit& visit) const {
    const Lattice& l = model.anatomy.lattice;
    for (int at = 0; at < kCellCorners; at++) {
      const Int3 cell = node - cell_corner(at);
      if (!is_whole_cell(model, state.cuts, cell)) continue;
      Vec3d u[kCellCorners];
      for (int c = 0; c < kCellCorners; c++)
        u[c] = Vec3d(state.motion.u[std::size_t(node_slot(l, cell + cell_corner(c)))]);
      u[at] += more;
      visit(node_slot(l, cell), at, u);
    }
  }

  double energy(Vec3d more) const {
    double sum = 0;
    for_each(more, [&](int slot, int, const Vec3d(&u)[kCellCorners]) {
      const CellModuli m = laws.all_moduli(slot, model.anatomy.cell_young[std::size_t(slot)]);
      const CellDeformation d = cell_deformation(u, model.anatomy.lattice.spacing);
      sum += law_energy(laws.energy_at(slot), d.f,
                        {m.shear, m.bulk, m.stiffening, m.fiber, m.fiber_stiffening, Vec3d(m.direction)}) +
             double(m.hourglass) * d.hourglass / 2;
      if (laws.history[0] == nullptr) return;
      const CellHistory h = laws.history_of(slot);
      const auto& [x, y, z] = d.f.column;
      sum += 0.5 * (h.xx * (dot(x, x) - 1) + h.yy * (dot(y, y) - 1) + h.zz * (dot(z, z) - 1)) +
             h.xy * dot(x, y) + h.xz * dot(x, z) + h.yz * dot(y, z);
    });
    return sum;
  }

  NodeSystem system() const {
    NodeSystem s;
    for_each({}, [&](int slot, int at, const Vec3d(&u)[kCellCorners]) {
      Vec3 d[kCellCorners];
      for (int c = 0; c < kCellCorners; c++) d[c] = Vec3(u[c] - u[at]);
      add_viscous_law_cell(s, cell_gradient(d, at, laws.slope), at, laws, slot,
                           model.anatomy.cell_young[std::size_t(slot)]);
    });
    return s;
  }
};

/// d · H d of a system.
double curvature(const NodeSystem& s, Vec3d d) {
  return s.xx * d.x * d.x + s.yy * d.y * d.y + s.zz * d.z * d.z +
         2 * (s.xy * d.x * d.y + s.xz * d.x * d.z + s.yz * d.y * d.z);
}

}  // namespace

Real law_step_share(const Model& model, const State& state, const CellLawView& laws, int slot,
                    const LawNodeStep& step) {
  // slope and curvature of all but the cells
  const CellsOfNode cells{model, state, laws, slot_node(model.anatomy.lattice, slot)};
  const NodeSystem own = cells.system();
  const Vec3d d(step.change);
  const double inertia = 1 / double(step.mobility);
  const double slope = -dot(Vec3d(step.system.f - own.f), d) - inertia * dot(Vec3d(step.to_inertial), d);
  const double bend = curvature(step.system, d) - curvature(own, d) + inertia * dot(d, d);
  // halve until the energy falls
  const double before = cells.energy({});
  double share = 1;
  for (; share > 1.0 / 64; share /= 2)
    if (cells.energy(d * share) - before + share * slope + 0.5 * share * share * bend <= 0) break;
  return Real(share);
}

}  // namespace turgor::lattice

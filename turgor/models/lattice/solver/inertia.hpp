// Inertial positions of nodes, and iteration over chunks of free nodes.
#pragma once

#include <algorithm>

#include "turgor/models/lattice/mechanics/node_systems.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"
#include "turgor/models/lattice/solver/step_kernels.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

/// Inertial displacement y = u_before + h v + h² g.
struct Inertia {
  const Real *bx, *by, *bz, *vx, *vy, *vz, *w;
  const std::uint8_t* removed;
  Vec3 fall;  // h² g [m]
  Real dt;

  Inertia(const Model& model, const State& s, const Inputs& inputs, double step)
      : bx(s.motion.u_before.x.data()),
        by(s.motion.u_before.y.data()),
        bz(s.motion.u_before.z.data()),
        vx(s.motion.v.x.data()),
        vy(s.motion.v.y.data()),
        vz(s.motion.v.z.data()),
        w(model.anatomy.inverse_mass.data()),
        removed(s.cuts.removed.data()),
        fall(lattice_gravity(model, inputs) * Real(step * step)),
        dt(Real(step)) {}
  /// From pointers, on host or device.
  Inertia(const FreeNodes& n, Vec3 falls, Real step)
      : bx(n.bx),
        by(n.by),
        bz(n.bz),
        vx(n.vx),
        vy(n.vy),
        vz(n.vz),
        w(n.nodes.w),
        removed(n.removed),
        fall(falls),
        dt(step) {}

  /// 1 for free nodes, else 0.
  TURGOR_HD Real moves(int s) const { return ((w[s] > 0) & (removed[s] == 0)) ? Real(1) : Real(0); }
  TURGOR_HD Vec3 operator()(int s) const { return at(s, moves(s)); }
  /// Inertial force m (y − u)/h² at displacement u; 0 at other nodes [N].
  TURGOR_HD Vec3 force(int s, Vec3 u) const {
    const Real m = moves(s) * (1 / (dt * dt)) / nonzero(w[s]);
    return (at(s, 1) - u) * m;
  }
  TURGOR_HD Vec3 at(int s, Real moves) const {
    return {bx[s] + moves * (dt * vx[s] + fall.x), by[s] + moves * (dt * vy[s] + fall.y),
            bz[s] + moves * (dt * vz[s] + fall.z)};
  }
};

/// Calls body(parity, slot, count) for chunks of free nodes of a half row.
template <class Body>
void for_each_chunk_of_half_row(const Model& model, int parity, int j, int k, const Body& body) {
  const Lattice& l = model.anatomy.lattice;
  for (const Run run : model.anatomy.free_runs.of_half_row(row_slot(l, j, k) / l.half + parity))
    for (int begin = 0; begin < run.count; begin += kLanes)
      body(parity, run.begin + begin, std::min(kLanes, run.count - begin));
}

/// Calls body(parity, slot, count) for chunks of free nodes in all awake rows of a layer, forward or
/// backward.
template <class Body>
void for_each_chunk(const Model& model, const std::uint8_t* awake, int k, const Body& body,
                    Order order = Order::kForward) {
  const Lattice& l = model.anatomy.lattice;
  const bool backward = order == Order::kBackward;
  for (int row = 0; row < l.size.y; row++)
    for (int pass = 0; pass < 2; pass++) {
      const int j = backward ? l.size.y - 1 - row : row, parity = backward ? 1 - pass : pass;
      if (awake != nullptr && !awake[row_of(model, row_slot(l, j, k))]) continue;
      for_each_chunk_of_half_row(model, parity, j, k, body);
    }
}

}  // namespace turgor::lattice

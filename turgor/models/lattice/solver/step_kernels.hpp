// Phases of both solvers before and after their sweeps: one call per node, on plain pointers. The host calls
// them for runs of nodes (predict_finish.cpp), a device for one node per thread.
#pragma once

#include <cmath>

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Results of a step besides the state.
struct StepSummary {
  std::uint32_t largest = 0;             // bits of the largest |v|² [m²/s²]
  std::uint32_t velocities_diverge = 0;  // 1 = velocities move neighbors too far apart
};

/// Nodes of a body on host or device. Pointers are to arrays by slot unless another count is given.
struct FreeNodes {
  int half, slots;  // Lattice::half
  NodeArrays nodes;
  Real *bx, *by, *bz, *vx, *vy, *vz;  // u_before [m], velocity [m/s]
  const std::uint8_t* removed;
  const int* free_groups;  // first slots of groups that contain free nodes
  int free_group_count;
  StepSummary* summary;  // one entry

  TURGOR_HD std::size_t count() const { return std::size_t(free_group_count) * kGroup; }
  TURGOR_HD int slot(std::size_t n) const { return free_groups[n / kGroup] + int(n % kGroup); }
  TURGOR_HD bool moves(int s) const { return (nodes.w[s] > 0) & (removed[s] == 0); }
  TURGOR_HD Vec3 v(int s) const { return {vx[s], vy[s], vz[s]}; }
};

/// Largest motion of neighbors relative to each other in a step, in cells, for a start with h v. From farther
/// off few sweeps do not recover, and their residual keeps the body in motion.
constexpr Real kLargestRelativeMotion = 0.5;

/// Detects uncut neighbors whose velocities exceed that motion.
struct FindDivergingNeighbors {
  FreeNodes n;
  Neighbors neighbors[2];  // by parity of i
  Real most;               // velocity difference [m/s]

  TURGOR_HD bool is_solid(int s) const { return n.nodes.root[s] > 0 && !n.removed[s]; }
  /// Test at the faster end of an edge.
  TURGOR_HD bool diverges(int s) const {
    const Vec3 v = n.v(s);
    if (!(4 * dot(v, v) > most * most) || !is_solid(s)) return false;
    const Neighbors& stencil = neighbors[s / n.half & 1];
    for (int e = 0; e < kNeighborCount; e++) {
      const int other = s + stencil.offset[e], lower = e % 2 == 0 ? s : other;
      if (is_cut(n.nodes.cut[lower], e / 2) || !is_solid(other)) continue;
      if (const Vec3 apart = n.v(other) - v; dot(apart, apart) > most * most) return true;
    }
    return false;
  }
  TURGOR_HD void operator()(std::size_t at) const {
    if (diverges(n.slot(at))) atomic_max(n.summary->velocities_diverge, 1);
  }
};
/// Nodes of a state on the host; without groups and summary.
inline FreeNodes host_free_nodes(const Model& model, State& state) {
  return {.half = model.anatomy.lattice.half,
          .slots = int(model.anatomy.inverse_mass.size()),
          .nodes = node_arrays(model, state),
          .bx = state.motion.u_before.x.data(),
          .by = state.motion.u_before.y.data(),
          .bz = state.motion.u_before.z.data(),
          .vx = state.motion.v.x.data(),
          .vy = state.motion.v.y.data(),
          .vz = state.motion.v.z.data(),
          .removed = state.cuts.removed.data()};
}
/// Velocity difference of neighbors above which a step of `dt` starts from rest [m/s].
inline Real largest_relative_speed(const Model& model, Real dt) {
  const Vec3 spacing = model.anatomy.lattice.spacing;
  return kLargestRelativeMotion * std::min({spacing.x, spacing.y, spacing.z}) / dt;
}

/// Predictor: u_before = u, then u += h v + h² g.
struct PredictNode {
  FreeNodes n;
  Vec3 fall;  // h² g, or 0 [m]
  Real dt;

  TURGOR_HD void predict(int s, Real velocity_step) const {
    const bool moves = n.moves(s);
    n.bx[s] = n.nodes.ux[s], n.by[s] = n.nodes.uy[s], n.bz[s] = n.nodes.uz[s];
    n.nodes.ux[s] += moves ? velocity_step * n.vx[s] + fall.x : 0;
    n.nodes.uy[s] += moves ? velocity_step * n.vy[s] + fall.y : 0;
    n.nodes.uz[s] += moves ? velocity_step * n.vz[s] + fall.z : 0;
  }
  TURGOR_HD void operator()(std::size_t at) const {
    predict(n.slot(at), n.summary->velocities_diverge ? 0 : dt);
  }
};

/// Loads: v += h w f. The thread of the first load of a node adds all loads of that node. Slots ascend.
struct AddLoad {
  FreeNodes n;
  const NodeLoad* loads;
  int count;
  Real dt;

  TURGOR_HD void add(const NodeLoad& load) const {
    const int s = load.slot;
    const Vec3 v = n.v(s) + load.force * (dt * n.nodes.w[s]);
    n.vx[s] = v.x, n.vy[s] = v.y, n.vz[s] = v.z;
  }
  TURGOR_HD void operator()(std::size_t at) const {
    const int first = int(at), s = loads[first].slot;
    if ((first > 0 && loads[first - 1].slot == s) || n.removed[s]) return;
    for (int l = first; l < count && loads[l].slot == s; l++) add(loads[l]);
  }
};

/// Velocities: v = (u − u_before)/h with damping. `finish` returns the bits of |v|².
struct FinishNode {
  FreeNodes n;
  Real scale;  // exp(−damping h)/h [1/s]

  TURGOR_HD std::uint32_t finish(int s) const {
    const Vec3 speed{(n.nodes.ux[s] - n.bx[s]) * scale, (n.nodes.uy[s] - n.by[s]) * scale,
                     (n.nodes.uz[s] - n.bz[s]) * scale};
    n.vx[s] = speed.x, n.vy[s] = speed.y, n.vz[s] = speed.z;
    return magnitude_bits(dot(speed, speed));
  }
  TURGOR_HD void operator()(std::size_t at) const { atomic_max(n.summary->largest, finish(n.slot(at))); }
};

/// Restores the displacement before the step, at rest. Projections may also leave non-finite values in fixed
/// nodes and in empty slots.
struct RestoreSlot {
  FreeNodes n;

  TURGOR_HD void operator()(std::size_t s) const {
    const auto restore = [moves = n.nodes.w[s] > 0](Real& u, Real before) {
      if (moves || !(u - u == 0)) u = before;
    };
    restore(n.nodes.ux[s], n.bx[s]), restore(n.nodes.uy[s], n.by[s]), restore(n.nodes.uz[s], n.bz[s]);
    n.vx[s] = n.vy[s] = n.vz[s] = 0;
  }
};

/// Damping over the time step, exp(−damping h)/h [1/s].
inline Real speed_scale(const SolverParams& solver, double dt) {
  return Real(std::exp(-solver.damping * dt) / dt);
}

/// Phases of a step (step_sequence.hpp) that both solvers share, by kernels. The summary must be reset
/// before. `loads` are in the same memory as the nodes; their slots ascend.
template <class Run>
struct NodeKernels {
  const Run& run;
  FreeNodes nodes;
  std::span<const NodeLoad> loads;
  double dt;
  Real scale;  // speed_scale

  void add_loads() const { run(loads.size(), AddLoad{nodes, loads.data(), int(loads.size()), Real(dt)}); }
  void finish() const { run(nodes.count(), FinishNode{nodes, scale}); }
};

}  // namespace turgor::lattice

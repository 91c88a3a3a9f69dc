// What both solvers do to every node before and after their sweeps, as loops over plain pointers: a thread a
// node. The same source runs on a CPU (CpuRun, ShuffledRun) and on a GPU; on a CPU step() is faster and means
// the same.
#pragma once

#include <cmath>

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// What a step leaves behind beside the state.
struct StepMarks {
  std::uint32_t largest = 0;  // bits of the largest |v|² [m²/s²]
  std::uint32_t wild = 0;     // 1 = velocities lead some neighbours too far apart
};

/// The nodes of a body on one side of the bus. Pointers are to arrays by slot unless another count is given.
struct MovingNodes {
  int half, slots;  // Lattice::half
  NodeArrays nodes;
  Real *bx, *by, *bz, *vx, *vy, *vz;  // u_before [m], velocity [m/s]
  const std::uint8_t* removed;
  const int* moving;  // first slots of groups in which something can move
  int moving_count;
  StepMarks* marks;  // one

  TURGOR_HD std::size_t count() const { return std::size_t(moving_count) * kGroup; }
  TURGOR_HD int slot(std::size_t n) const { return moving[n / kGroup] + int(n % kGroup); }
  TURGOR_HD bool moves(int s) const { return nodes.w[s] > 0 && !removed[s]; }
  TURGOR_HD Vec3 v(int s) const { return {vx[s], vy[s], vz[s]}; }
};

/// How far neighbours may go apart or together in a step by their velocities, in lattice steps, if descent is
/// to begin where those lead: from farther off few sweeps do not come back, and what they leave of the way
/// moves the body on.
constexpr Real kTameWay = 0.5;

/// Do velocities lead neighbours that no blade parted farther than that?
struct FindWild {
  MovingNodes n;
  Neighbors neighbors[2];  // by the parity of i
  Real most;               // difference of velocities [m/s]

  TURGOR_HD bool is_solid(int s) const { return n.nodes.root[s] > 0 && !n.removed[s]; }
  /// Seen from the faster end.
  TURGOR_HD bool is_wild(int s) const {
    const Vec3 v = n.v(s);
    if (!(4 * dot(v, v) > most * most) || !is_solid(s)) return false;
    const Neighbors& around = neighbors[s / n.half & 1];
    for (int e = 0; e < kNeighborCount; e++) {
      const int other = s + around.offset[e], lower = e % 2 == 0 ? s : other;
      if (n.nodes.cut[lower] >> e / 2 & 1 || !is_solid(other)) continue;
      if (const Vec3 apart = n.v(other) - v; dot(apart, apart) > most * most) return true;
    }
    return false;
  }
  TURGOR_HD void operator()(std::size_t at) const {
    if (is_wild(n.slot(at))) atomic_max(n.marks->wild, 1);
  }
};
/// On a CPU, of the body itself; without groups and marks.
inline MovingNodes moving_nodes(const Model& model, State& state) {
  return {.half = model.lattice.half,
          .slots = int(model.inverse_mass.size()),
          .nodes = node_arrays(model, state),
          .bx = state.u_before.x.data(),
          .by = state.u_before.y.data(),
          .bz = state.u_before.z.data(),
          .vx = state.v.x.data(),
          .vy = state.v.y.data(),
          .vz = state.v.z.data(),
          .removed = state.removed.data()};
}
/// Difference of velocities from which on a step of `dt` leads too far [m/s].
inline Real wild_from(const Model& model, Real dt) {
  const Vec3 step = model.lattice.step;
  return kTameWay * std::min({step.x, step.y, step.z}) / dt;
}

/// u_before = u; u to where inertia and gravity lead.
struct PredictNode {
  MovingNodes n;
  Vec3 fall;  // h² g, or 0 [m]
  Real dt;

  TURGOR_HD void operator()(std::size_t at) const {
    const int s = n.slot(at);
    const bool moves = n.moves(s);
    const Real way = n.marks->wild ? 0 : dt;
    n.bx[s] = n.nodes.ux[s], n.by[s] = n.nodes.uy[s], n.bz[s] = n.nodes.uz[s];
    n.nodes.ux[s] += moves ? way * n.vx[s] + fall.x : 0;
    n.nodes.uy[s] += moves ? way * n.vy[s] + fall.y : 0;
    n.nodes.uz[s] += moves ? way * n.vz[s] + fall.z : 0;
  }
};

/// v += h w f, for all loads of one node by the thread of the first. Their slots ascend.
struct AddLoad {
  MovingNodes n;
  const NodeLoad* loads;
  int count;
  Real dt;

  TURGOR_HD void operator()(std::size_t at) const {
    int l = int(at);
    const int s = loads[l].slot;
    if ((l > 0 && loads[l - 1].slot == s) || n.removed[s]) return;
    Vec3 v = n.v(s);
    for (; l < count && loads[l].slot == s; l++) v = v + loads[l].force * (dt * n.nodes.w[s]);
    n.vx[s] = v.x, n.vy[s] = v.y, n.vz[s] = v.z;
  }
};

/// v = (u − u_before)/h, damped.
struct FinishNode {
  MovingNodes n;
  Real scale;  // exp(−damping h)/h [1/s]

  TURGOR_HD void operator()(std::size_t at) const {
    const int s = n.slot(at);
    const Vec3 speed{(n.nodes.ux[s] - n.bx[s]) * scale, (n.nodes.uy[s] - n.by[s]) * scale,
                     (n.nodes.uz[s] - n.bz[s]) * scale};
    n.vx[s] = speed.x, n.vy[s] = speed.y, n.vz[s] = speed.z;
    atomic_max(n.marks->largest, magnitude_bits(dot(speed, speed)));
  }
};

/// To where the step began, at rest. Projections leave what is not finite in nodes that are held and in slots
/// without a node, too.
struct GoBackSlot {
  MovingNodes n;

  TURGOR_HD void operator()(std::size_t s) const {
    const auto go_back = [moves = n.nodes.w[s] > 0](Real& u, Real before) {
      if (moves || !(u - u == 0)) u = before;
    };
    go_back(n.nodes.ux[s], n.bx[s]), go_back(n.nodes.uy[s], n.by[s]), go_back(n.nodes.uz[s], n.bz[s]);
    n.vx[s] = n.vy[s] = n.vz[s] = 0;
  }
};

/// Damping and the length of the step [1/s].
inline Real speed_scale(const SolverParams& solver, double dt) {
  return Real(std::exp(-solver.damping * dt) / dt);
}

}  // namespace turgor::lattice

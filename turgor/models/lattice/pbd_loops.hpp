// A step of position-based dynamics by colours, as loops over plain pointers: a thread a cell, a thread a
// node. The same source runs on a CPU (CpuRun, ShuffledRun) and on a GPU; on a CPU step() is faster and means
// the same.
#pragma once

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/lattice/colours.hpp"
#include "turgor/models/lattice/pbd_kernels.hpp"

namespace turgor::lattice {

/// Everything that does not change, by value.
struct PbdRules {
  int half;                             // Lattice::half
  int family_offset[2][kFamilyCount];   // by the parity of i [slots]
  Vec3 edge[kFamilyCount];              // rest vectors [m]
  Real rest[kFamilyCount];              // [m]
  CellTet tet[2][6];                    // by the parity of i
  Real rest_volume;                     // [m³]; 0: volumes are not projected
  Real skin_ratio, skin_amplification;  // rest area by that in the CT [1]; β [1]
};

struct PbdSchedule {
  std::vector<int> moving;   // first slots of groups in which something can move
  std::vector<int> joining;  // and of those whose cells hold something that can, by colours
  std::vector<int> heads;    // the first triangle of each cell with skin, by colours
  std::vector<int> next;     // by triangle: another one of its cell, or -1
  ColourBegin joining_of, heads_of;
};

/// A body on one side of the bus. Pointers are to arrays by slot unless another count is given.
struct PbdView {
  PbdRules rules;
  int slots;
  NodeArrays nodes;
  Real *bx, *by, *bz, *vx, *vy, *vz;  // u_before [m], velocity [m/s]
  const std::uint8_t* removed;
  const int* moving;  // PbdSchedule
  int moving_count;
  const int* joining;
  ColourBegin joining_of;
  const SkinTriangle* triangles;
  const std::uint8_t* skin_cut;  // by triangle
  const int *next, *heads;
  ColourBegin heads_of;
  std::uint32_t* largest;  // one number: bits of the largest |v|² [m²/s²]
};

PbdRules pbd_rules(const Model& model);
PbdSchedule pbd_schedule(const Model& model);
/// On a CPU: of the body itself.
PbdView pbd_view(const Model& model, const PbdSchedule& schedule, State& state, std::uint32_t& largest);

/// u_before = u; u to where inertia and gravity lead.
struct PredictNode {
  PbdView v;
  Vec3 fall;  // h² g [m]
  Real dt;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.moving[n / kGroup] + int(n % kGroup);
    const bool moves = v.nodes.w[s] > 0 && !v.removed[s];
    v.bx[s] = v.nodes.ux[s], v.by[s] = v.nodes.uy[s], v.bz[s] = v.nodes.uz[s];
    v.nodes.ux[s] += moves ? dt * v.vx[s] + fall.x : 0;
    v.nodes.uy[s] += moves ? dt * v.vy[s] + fall.y : 0;
    v.nodes.uz[s] += moves ? dt * v.vz[s] + fall.z : 0;
  }
};

/// The edges and tetrahedra of a cell.
struct ProjectCell {
  PbdView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.joining[std::size_t(begin) + n / kGroup] + int(n % kGroup);
    if (!(v.nodes.root[s] > 0)) return;  // behind the end of a row, too: there is somebody else's node
    const int parity = s / v.rules.half & 1;
    for (int f = 0; f < kFamilyCount; f++)
      project_edges<true, 1>(v.nodes, s, s + v.rules.family_offset[parity][f], v.rules.edge[f],
                             v.rules.rest[f], f);
    for (int t = 0; t < 6 && v.rules.rest_volume > 0; t++)
      project_volumes<true>(v.nodes, v.rules.tet[parity][t], s, 1, v.rules.rest_volume);
  }
};

/// The skin of a cell, one triangle after the other.
struct ProjectSkinCell {
  PbdView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const {
    for (int t = v.heads[std::size_t(begin) + n]; t >= 0; t = v.next[t])
      if (!v.skin_cut[t]) project(v.triangles[t]);
  }
  TURGOR_HD void project(const SkinTriangle& t) const {
    const auto [a, b, c] = t.vertex;
    const Vec3 here = v.nodes.u(a);
    const SkinShift shift =
        project_skin({0, 0, 0}, t.edge1 + (v.nodes.u(b) - here), t.edge2 + (v.nodes.u(c) - here),
                     {v.nodes.w[a], v.nodes.w[b], v.nodes.w[c]}, v.rules.skin_ratio * t.area, t.stiffness,
                     v.rules.skin_amplification);
    move(a, shift.a), move(b, shift.b), move(c, shift.c);
  }
  TURGOR_HD void move(int s, Vec3 by) const {
    v.nodes.ux[s] += by.x, v.nodes.uy[s] += by.y, v.nodes.uz[s] += by.z;
  }
};

/// v = (u − u_before)/h, damped.
struct FinishNode {
  PbdView v;
  Real scale;  // exp(−damping h)/h [1/s]

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.moving[n / kGroup] + int(n % kGroup);
    const Vec3 speed{(v.nodes.ux[s] - v.bx[s]) * scale, (v.nodes.uy[s] - v.by[s]) * scale,
                     (v.nodes.uz[s] - v.bz[s]) * scale};
    v.vx[s] = speed.x, v.vy[s] = speed.y, v.vz[s] = speed.z;
    atomic_max(*v.largest, magnitude_bits(dot(speed, speed)));
  }
};

/// To where the step began, at rest. Projections leave what is not finite in nodes that are held and in slots
/// without a node, too.
struct GoBackSlot {
  PbdView v;

  TURGOR_HD void operator()(std::size_t s) const {
    const auto go_back = [moves = v.nodes.w[s] > 0](Real& u, Real before) {
      if (moves || !(u - u == 0)) u = before;
    };
    go_back(v.nodes.ux[s], v.bx[s]), go_back(v.nodes.uy[s], v.by[s]), go_back(v.nodes.uz[s], v.bz[s]);
    v.vx[s] = v.vy[s] = v.vz[s] = 0;
  }
};

/// One sweep.
template <class Run>
void sweep_pbd_with(const Run& run, const PbdView& v) {
  for (int c = 0; c < kColourCount; c++) {
    const int *cells = v.joining_of.begin + c, *skin = v.heads_of.begin + c;
    run(std::size_t(cells[1] - cells[0]) * kGroup, ProjectCell{v, cells[0]});
    run(std::size_t(skin[1] - skin[0]), ProjectSkinCell{v, skin[0]});
  }
}

/// What a step does to the view's arrays; `largest` must be 0 before.
template <class Run>
void step_pbd_with(const Run& run, const PbdView& v, Vec3 gravity, const SolverParams& solver, double dt) {
  const std::size_t moving = std::size_t(v.moving_count) * kGroup;
  run(moving, PredictNode{v, gravity * Real(dt * dt), Real(dt)});
  for (int sweep = 0; sweep < solver.sweeps; sweep++) sweep_pbd_with(run, v);
  run(moving, FinishNode{v, Real(std::exp(-solver.damping * dt) / dt)});
}
template <class Run>
void go_back_with(const Run& run, const PbdView& v) {
  run(std::size_t(v.slots), GoBackSlot{v});
}

}  // namespace turgor::lattice

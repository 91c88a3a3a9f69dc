// A step of position-based dynamics by colours, as loops over plain pointers: a thread a cell, a thread a
// node. The same source runs on a CPU (CpuRun, ShuffledRun) and on a GPU; on a CPU step() is faster and means
// the same.
#pragma once

#include "turgor/models/lattice/colours.hpp"
#include "turgor/models/lattice/pbd_kernels.hpp"
#include "turgor/models/lattice/step_loops.hpp"

namespace turgor::lattice {

/// Everything that does not change, by value.
struct PbdRules {
  int family_offset[2][kFamilyCount];   // by the parity of i [slots]
  Vec3 edge[kFamilyCount];              // rest vectors [m]
  Real rest[kFamilyCount];              // [m]
  CellTet tet[2][6];                    // by the parity of i
  Real rest_volume;                     // [m³]; 0: volumes are not projected
  Real skin_ratio, skin_amplification;  // rest area by that in the CT [1]; β [1]
};

struct PbdSchedule {
  std::vector<int> joining;  // first slots of groups whose cells hold something that can move, by colours
  std::vector<int> heads;    // the first triangle of each cell with skin, by colours
  std::vector<int> next;     // by triangle: another one of its cell, or -1
  ColourBegin joining_of, heads_of;
};

/// A body on one side of the bus, for pbd.
struct PbdView {
  PbdRules rules;
  MovingNodes body;
  const int* joining;  // PbdSchedule
  ColourBegin joining_of;
  const SkinTriangle* triangles;
  const std::uint8_t* skin_cut;  // by triangle
  const int *next, *heads;
  ColourBegin heads_of;
};

PbdRules pbd_rules(const Model& model);
PbdSchedule pbd_schedule(const Model& model);

/// The edges and tetrahedra of a cell.
struct ProjectCell {
  PbdView v;
  int begin;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.joining[std::size_t(begin) + n / kGroup] + int(n % kGroup);
    if (!(v.body.nodes.root[s] > 0)) return;  // behind the end of a row, too: there is somebody else's node
    const int parity = s / v.body.half & 1;
    for (int f = 0; f < kFamilyCount; f++)
      project_edges<true, 1>(v.body.nodes, s, s + v.rules.family_offset[parity][f], v.rules.edge[f],
                             v.rules.rest[f], f);
    for (int t = 0; t < 6 && v.rules.rest_volume > 0; t++)
      project_volumes<true>(v.body.nodes, v.rules.tet[parity][t], s, 1, v.rules.rest_volume);
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
    const Vec3 here = v.body.nodes.u(a);
    const SkinShift shift =
        project_skin({0, 0, 0}, t.edge1 + (v.body.nodes.u(b) - here), t.edge2 + (v.body.nodes.u(c) - here),
                     {v.body.nodes.w[a], v.body.nodes.w[b], v.body.nodes.w[c]}, v.rules.skin_ratio * t.area,
                     t.stiffness, v.rules.skin_amplification);
    move(a, shift.a), move(b, shift.b), move(c, shift.c);
  }
  TURGOR_HD void move(int s, Vec3 by) const {
    v.body.nodes.ux[s] += by.x, v.body.nodes.uy[s] += by.y, v.body.nodes.uz[s] += by.z;
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

/// What a step does to the view's arrays; the marks must be fresh. `loads` are on the same side, their slots
/// ascend.
template <class Run>
void step_pbd_with(const Run& run, const PbdView& v, std::span<const NodeLoad> loads, Vec3 gravity,
                   const SolverParams& solver, double step) {
  const Real dt = Real(step);
  run(loads.size(), AddLoad{v.body, loads.data(), int(loads.size()), dt});
  run(v.body.count(),
      PredictNode{v.body, {dt * dt * gravity.x, dt * dt * gravity.y, dt * dt * gravity.z}, dt});
  for (int sweep = 0; sweep < solver.sweeps; sweep++) sweep_pbd_with(run, v);
  run(v.body.count(), FinishNode{v.body, speed_scale(solver, step)});
}

}  // namespace turgor::lattice

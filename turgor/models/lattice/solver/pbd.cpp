// Position-based dynamics on the lattice, as in the paper: springs, optional volumes, then skin. A layer of
// cells is processed row by row. Both ends of an edge family are contiguous runs without a common node, so
// SIMD lanes never conflict.
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/solver/projections.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// Calls body.template lanes<width>(begin) on [0, count): full vectors (loops of constant length vectorize),
/// half a vector, then single slots at the end of a row.
template <class Body>
void for_vector_widths(int count, const Body& body) {
  int i = 0;
  for (; i + 16 <= count; i += 16) body.template lanes<16>(i);
  if (i + kGroup <= count) body.template lanes<kGroup>(i), i += kGroup;
  for (; i < count; i++) body.template lanes<1>(i);
}

template <bool kWithCuts>
struct EdgeRun {
  const NodeArrays& n;
  int a, b;
  Vec3 edge;
  Real rest;
  int family;

  template <int kWidth>
  void lanes(int i) const {
    project_edges<kWithCuts, kWidth>(n, a + i, b + i, edge, rest, family);
  }
};

/// Runs of a row that take part in projections. A run ends at the last node of its half row, because the next
/// slot may belong to the other half.
struct RowRuns {
  int j, k;
  std::span<const Run> of[2];
  int end[2];

  RowRuns(const Model& model, int at_j, int at_k) : j(at_j), k(at_k) {
    const Lattice& l = model.anatomy.lattice;
    const int row = row_slot(l, j, k);
    for (int parity = 0; parity < 2; parity++) {
      of[parity] = model.pbd.constraint_runs.of_half_row(row / l.half + parity);
      end[parity] = row + parity * l.half + half_count(l, parity);
    }
  }
  /// Calls body(first slot, count).
  template <class Body>
  void for_each(int parity, const Body& body) const {
    for (const Run run : of[parity]) body(run.begin, std::min(run.count, end[parity] - run.begin));
  }
};

/// Projects all edges whose lower end is in a row or half row, then the tetrahedra of its cells.
struct SweepRow {
  const Model& model;
  NodeArrays nodes;
  const std::uint8_t* row_cut;
  std::array<Vec3, kFamilyCount> edges;

  SweepRow(const Model& m, State& s)
      : model(m),
        nodes(node_arrays(m, s)),
        row_cut(s.cuts.row_cut.data()),
        edges(rest_edges(m.anatomy.lattice)) {}

  /// Projects kHalves half rows, from parity `first` on.
  template <bool kWithCuts, int kHalves>
  void project_family(int f, const RowRuns& row, int first) const {
    const Lattice& l = model.anatomy.lattice;
    const Int3 offset = kFamilies[std::size_t(f)];
    if (row.j + offset.y >= l.size.y || row.k + offset.z >= l.size.z) return;
    const Vec3 edge = edges[std::size_t(f)];
    const Real rest = model.springs.rest_length[std::size_t(f)];
    for (int parity = first; parity < first + kHalves; parity++)
      row.for_each(parity, [&](int a, int count) {
        for_vector_widths(count,
                          EdgeRun<kWithCuts>{nodes, a, a + slot_offset(l, offset, parity), edge, rest, f});
      });
  }

  template <bool kWithCuts, int kHalves>
  void sweep(const RowRuns& row, int first) const {
    // springs
    for (int f = 0; f < kFamilyCount; f++) project_family<kWithCuts, kHalves>(f, row, first);
    // volumes
    const Lattice& l = model.anatomy.lattice;
    if (model.springs.volume_scale <= 0 || row.j + 1 >= l.size.y || row.k + 1 >= l.size.z) return;
    for (const auto& tet : kKuhnTets)
      for (int parity = first; parity < first + kHalves; parity++)
        row.for_each(parity, [&](int cell, int count) {
          project_volumes<kWithCuts>(nodes, cell_tet(l, parity, tet), cell, count, model.springs.rest_volume);
        });
  }

  void operator()(int j, int k) const {
    const RowRuns row(model, j, k);
    if (row.of[0].empty() && row.of[1].empty()) return;
    is_cut(j, k) ? sweep<true, 2>(row, 0) : sweep<false, 2>(row, 0);
  }
  /// Cells of one color share no node. So the order of cells and edge families does not matter.
  void operator()(HalfRow half) const {
    const RowRuns row(model, half.j, half.k);
    if (row.of[half.parity].empty()) return;
    is_cut(half.j, half.k) ? sweep<true, 1>(row, half.parity) : sweep<false, 1>(row, half.parity);
  }
  bool is_cut(int j, int k) const {
    return row_cut[row_slot(model.anatomy.lattice, j, k) / row_stride(model.anatomy.lattice)];
  }
};

/// Batch of skin triangles during projection, one per lane.
struct SkinLanes {
  alignas(64) Real x[9][kSkinLanes];  // x[3 c + a]: corner c, axis a; displacement, then its correction [m]
  alignas(64) Real w[3][kSkinLanes];

  void fetch(const SkinBatch& batch, const NodeArrays& n) {
    for (int q = 0; q < 3; q++)
      for (int i = 0; i < kSkinLanes; i++) {
        const int slot = batch.vertex[q][i];
        x[3 * q][i] = n.ux[slot], x[3 * q + 1][i] = n.uy[slot], x[3 * q + 2][i] = n.uz[slot];
        w[q][i] = n.w[slot];
      }
  }

  void project(const SkinBatch& batch, Real ratio, Real amplification) {
    TURGOR_LANES
    for (int i = 0; i < kSkinLanes; i++) {
      const auto edge = [&](int q) {
        return Vec3{batch.edge[q][0][i], batch.edge[q][1][i], batch.edge[q][2][i]};
      };
      const auto u = [&](int q) { return Vec3{x[3 * q][i], x[3 * q + 1][i], x[3 * q + 2][i]}; };
      const SkinShift shift =
          project_skin_triangle({u(0), u(1), u(2)}, edge(0), edge(1), {w[0][i], w[1][i], w[2][i]},
                                ratio * batch.area[i], batch.stiffness[i], amplification);
      x[0][i] = shift.a.x, x[1][i] = shift.a.y, x[2][i] = shift.a.z;
      x[3][i] = shift.b.x, x[4][i] = shift.b.y, x[5][i] = shift.b.z;
      x[6][i] = shift.c.x, x[7][i] = shift.c.y, x[8][i] = shift.c.z;
    }
  }
};

/// Projects the batches of a group of skin: gather corners into lanes, project all lanes, add corrections to
/// the nodes.
struct ProjectSkin {
  const Skin& skin;
  const std::vector<SkinBatch>& batches;
  const std::uint8_t* skin_cut;
  NodeArrays n;
  Real ratio, amplification;

  ProjectSkin(const Model& model, State& state)
      : skin(model.anatomy.skin),
        batches(model.pbd.skin_batches),
        skin_cut(state.cuts.skin_cut.data()),
        n(node_arrays(model, state)),
        ratio(rest_area_ratio(model.params.skin)),
        amplification(Real(model.params.skin.amplification)) {}

  void operator()(int group) const {
    TURGOR_CHECK(is_index(group + 1, skin.layer_begin.size()), "a group of skin triangles is in a layer");
    SkinLanes lanes;
    const auto at = std::size_t(group);
    for (auto b = std::size_t(skin.layer_begin[at]); b < std::size_t(skin.layer_begin[at + 1]); b++) {
      const SkinBatch& batch = batches[b];
      lanes.fetch(batch, n);
      lanes.project(batch, ratio, amplification);
      add(lanes, batch, skin.batch_begin[b], skin.batch_begin[b + 1] - skin.batch_begin[b]);
    }
  }

  void add(const SkinLanes& lanes, const SkinBatch& batch, int begin, int count) const {
    TURGOR_CHECK(count <= kSkinLanes, "a batch has at most one triangle a lane");
    for (int i = 0; i < count; i++) {
      if (skin_cut[begin + i]) continue;
      for (int q = 0; q < 3; q++) {
        const int slot = batch.vertex[q][i];
        n.ux[slot] += lanes.x[3 * q][i], n.uy[slot] += lanes.x[3 * q + 1][i],
            n.uz[slot] += lanes.x[3 * q + 2][i];
      }
    }
  }
};

/// Skin of one color, by layer.
struct ProjectSkinOfColor {
  const ProjectSkin& skin;
  int color;

  void operator()(std::size_t n) const { skin(4 * (2 * int(n) + (color >> 2)) + (color & 3)); }
};

void sweep_pbd_by_slabs(const Exec& exec, const Model& model, State& state, const HaloExchange* halo) {
  const SweepRow sweep_row(model, state);
  const ProjectSkin skin(model, state);
  const bool with_skin = !model.anatomy.skin.triangles.empty();
  const auto sweep_layer = [&](int k) {
    for (int j = 0; j < model.anatomy.lattice.size.y; j++) sweep_row(j, k);
    if (with_skin && k + 1 < model.anatomy.lattice.size.z) skin(k);
  };
  sweep_slabs(exec, model.anatomy.owned, sweep_layer, Order::kForward, halo);
}

}  // namespace

template <class Run>
void sweep_pbd_by_colors(const Run& run, const Model& model, State& state) {
  const SweepRow sweep_row(model, state);
  const ProjectSkin skin(model, state);
  const Int3 size = model.anatomy.lattice.size;
  for (int color = 0; color < kColorCount; color++) {
    run_half_rows(run, size, color, sweep_row);
    if (!model.anatomy.skin.triangles.empty())
      run(std::size_t(size.z - (color >> 2)) / 2, ProjectSkinOfColor{skin, color});
  }
}
template void sweep_pbd_by_colors(const CpuRun&, const Model&, State&);
template void sweep_pbd_by_colors(const ShuffledRun&, const Model&, State&);

void sweep_pbd(const Exec& exec, const Model& model, State& state, const HaloExchange* halo) {
  TURGOR_CHECK(state.motion.u.x.size() >= model.anatomy.inverse_mass.size(), "positions are on the host");
  if (model.params.solver.ordering == Ordering::kColors)
    return sweep_pbd_by_colors(CpuRun{exec}, model, state);
  sweep_pbd_by_slabs(exec, model, state, halo);
}

}  // namespace turgor::lattice

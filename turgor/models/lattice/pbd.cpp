// Position-based dynamics on the lattice, as in the paper: springs, then volumes if asked for, then skin. A
// layer of cells is done row by row; both ends of an edge family are contiguous runs of nodes without a node
// in common, so lanes never meet.
#include "turgor/models/lattice/kernels.hpp"
#include "turgor/models/lattice/rows.hpp"
#include "turgor/models/lattice/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// Calls body.template lanes<width>(begin) on [0, count): whole vectors, as compilers make them of loops of
/// constant length, then half a one, then what is left at the end of a row.
template <class Body>
void in_vectors(int count, const Body& body) {
  int i = 0;
  for (; i + 16 <= count; i += 16) body.template lanes<16>(i);
  if (i + kGroup <= count) body.template lanes<kGroup>(i), i += kGroup;
  for (; i < count; i++) body.template lanes<1>(i);
}

/// `width` edges of one family between two runs of nodes; a and b are the first slots of the runs.
template <bool kWithCuts, int kWidth>
inline void project_edges(const NodeArrays& n, int a, int b, Vec3 edge, Real rest, int family) {
  Real* __restrict ax = n.ux + a, * __restrict ay = n.uy + a, * __restrict az = n.uz + a;
  Real* __restrict bx = n.ux + b, * __restrict by = n.uy + b, * __restrict bz = n.uz + b;
  const Real* __restrict wa = n.w + a, * __restrict wb = n.w + b, * __restrict ra = n.root + a, * __restrict rb = n.root + b;
  const std::uint8_t* __restrict cut = n.cut + a;
  const auto [ex, ey, ez] = edge;
  TURGOR_LANES
  for (int i = 0; i < kWidth; i++) {
    const Vec3 d{ex + (bx[i] - ax[i]), ey + (by[i] - ay[i]), ez + (bz[i] - az[i])};
    Real stiffness = ra[i] * rb[i];
    if constexpr (kWithCuts) stiffness = cut[i] >> family & 1 ? 0 : stiffness;
    const Real s = project_spring(d, rest, stiffness, wa[i], wb[i]);
    const Real sa = s * wa[i], sb = s * wb[i];
    ax[i] += sa * d.x, ay[i] += sa * d.y, az[i] += sa * d.z;
    bx[i] -= sb * d.x, by[i] -= sb * d.y, bz[i] -= sb * d.z;
  }
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

/// Four runs of corner nodes, for tetrahedra of one kind whose cells have i of one parity: they share no
/// node.
struct TetRuns {
  int slot[4];
  Vec3 e1, e2, e3;  // rest edges from the first corner [m]
  struct {
    int corner, family;
  } edge[6];  // lower end and family
};

template <bool kWithCuts>
void project_volumes(const NodeArrays& n, const TetRuns& runs, int count, Real rest_volume) {
  const auto [a, b, c, d] = runs.slot;
  Real* __restrict ax = n.ux + a, * __restrict ay = n.uy + a, * __restrict az = n.uz + a;
  Real* __restrict bx = n.ux + b, * __restrict by = n.uy + b, * __restrict bz = n.uz + b;
  Real* __restrict cx = n.ux + c, * __restrict cy = n.uy + c, * __restrict cz = n.uz + c;
  Real* __restrict dx = n.ux + d, * __restrict dy = n.uy + d, * __restrict dz = n.uz + d;
  const Real* __restrict wa = n.w + a, * __restrict wb = n.w + b, * __restrict wc = n.w + c, * __restrict wd = n.w + d;
  const Real* __restrict ra = n.root + a, * __restrict rb = n.root + b, * __restrict rc = n.root + c, * __restrict rd = n.root + d;
  const auto [e1x, e1y, e1z] = runs.e1;
  const auto [e2x, e2y, e2z] = runs.e2;
  const auto [e3x, e3y, e3z] = runs.e3;
  TURGOR_LANES
  for (int i = 0; i < count; i++) {
    const Vec3 e1{e1x + (bx[i] - ax[i]), e1y + (by[i] - ay[i]), e1z + (bz[i] - az[i])};
    const Vec3 e2{e2x + (cx[i] - ax[i]), e2y + (cy[i] - ay[i]), e2z + (cz[i] - az[i])};
    const Vec3 e3{e3x + (dx[i] - ax[i]), e3y + (dy[i] - ay[i]), e3z + (dz[i] - az[i])};
    Real stiffness = tet_stiffness(ra[i], rd[i], rb[i], rc[i], rd[i]);
    if constexpr (kWithCuts) {
      int cut = 0;
      for (const auto& edge : runs.edge) cut |= n.cut[runs.slot[edge.corner] + i] >> edge.family & 1;
      stiffness = cut ? 0 : stiffness;
    }
    const VolumeGradients g = volume_gradients(e1, e2, e3);
    const Real s = project_volume(e1, g, rest_volume, stiffness, wa[i], wb[i], wc[i], wd[i]);
    const Real sa = -s * wa[i], sb = s * wb[i], sc = s * wc[i], sd = s * wd[i];
    const Vec3 g0 = g.g1 + g.g2 + g.g3;
    ax[i] += sa * g0.x, ay[i] += sa * g0.y, az[i] += sa * g0.z;
    bx[i] += sb * g.g1.x, by[i] += sb * g.g1.y, bz[i] += sb * g.g1.z;
    cx[i] += sc * g.g2.x, cy[i] += sc * g.g2.y, cz[i] += sc * g.g2.z;
    dx[i] += sd * g.g3.x, dy[i] += sd * g.g3.y, dz[i] += sd * g.g3.z;
  }
}

TetRuns tet_runs(const Lattice& l, int first, int parity, const std::array<Int3, 4>& tet) {
  TetRuns runs{};
  for (int c = 0; c < 4; c++) runs.slot[c] = first + slot_offset(l, tet[std::size_t(c)], parity);
  const auto rest = [&](int c) { return hadamard(l.step, Vec3(tet[std::size_t(c)] - tet[0])); };
  runs.e1 = rest(1), runs.e2 = rest(2), runs.e3 = rest(3);
  int e = 0;
  for (int p = 0; p < 4; p++)
    for (int q = p + 1; q < 4; q++, e++) {
      const Int3 offset = tet[std::size_t(q)] - tet[std::size_t(p)];
      const bool forward = family_of(offset) >= 0;
      runs.edge[e] = {forward ? p : q, family_of(forward ? offset : -offset)};
    }
  return runs;
}

/// All edges whose lower end is in row (j, k), then the tetrahedra of the row of cells there.
struct SweepRow {
  const Model& model;
  NodeArrays nodes;
  const std::uint8_t* row_cut;
  std::array<Vec3, kFamilyCount> edges;

  /// Calls body(first slot, count) where half a row has something to project. No run goes beyond the row's
  /// last node: the slot behind it may be the first of the other half.
  template <class Body>
  void for_each_run(std::span<const Run> runs, int row, int parity, const Body& body) const {
    const int end = row + parity * model.lattice.half + half_count(model.lattice, parity);
    for (const Run run : runs) body(run.begin, std::min(run.count, end - run.begin));
  }

  template <bool kWithCuts>
  void sweep(int j, int k) const {
    const Lattice& l = model.lattice;
    const int row = row_slot(l, j, k);
    const std::span<const Run> runs[2] = {model.joining.of_half_row(row / l.half),
                                          model.joining.of_half_row(row / l.half + 1)};
    if (runs[0].empty() && runs[1].empty()) return;
    for (int f = 0; f < kFamilyCount; f++) {
      const Int3 offset = kFamilies[std::size_t(f)];
      if (j + offset.y >= l.size.y || k + offset.z >= l.size.z) continue;
      const Vec3 edge = edges[std::size_t(f)];
      const Real rest = model.rest_length[std::size_t(f)];
      for (int parity = 0; parity < 2; parity++)
        for_each_run(runs[parity], row, parity, [&](int a, int count) {
          in_vectors(count, EdgeRun<kWithCuts>{nodes, a, a + slot_offset(l, offset, parity), edge, rest, f});
        });
    }
    if (model.volume_scale <= 0 || j + 1 >= l.size.y || k + 1 >= l.size.z) return;
    for (const auto& tet : kKuhnTets)
      for (int parity = 0; parity < 2; parity++)
        for_each_run(runs[parity], row, parity, [&](int first, int count) {
          project_volumes<kWithCuts>(nodes, tet_runs(l, first, parity, tet), count, model.rest_volume);
        });
  }

  void operator()(int j, int k) const {
    const int row = row_slot(model.lattice, j, k) / row_stride(model.lattice);
    row_cut[row] ? sweep<true>(j, k) : sweep<false>(j, k);
  }
};

/// A batch of skin triangles on its way through the projection: one lane each.
struct SkinLanes {
  alignas(64) Real x[9][kSkinLanes];  // of corner c along axis a, x[3 c + a]: displacement, then shift
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
        const auto& rest = batch.edge[q - 1];
        return Vec3{rest[0][i] + (x[3 * q][i] - x[0][i]), rest[1][i] + (x[3 * q + 1][i] - x[1][i]),
                    rest[2][i] + (x[3 * q + 2][i] - x[2][i])};
      };
      const SkinShift shift = project_skin({0, 0, 0}, edge(1), edge(2), {w[0][i], w[1][i], w[2][i]},
                                           ratio * batch.area[i], batch.stiffness[i], amplification);
      x[0][i] = shift.a.x, x[1][i] = shift.a.y, x[2][i] = shift.a.z;
      x[3][i] = shift.b.x, x[4][i] = shift.b.y, x[5][i] = shift.b.z;
      x[6][i] = shift.c.x, x[7][i] = shift.c.y, x[8][i] = shift.c.z;
    }
  }
};

/// Projects batch after batch of a layer: corners into lanes, all lanes at once, shifts back to the corners.
void project_skin_layer(const Model& model, const State& state, const NodeArrays& n, int k) {
  const Real ratio = rest_area_ratio(model.params.skin),
             amplification = Real(model.params.skin.amplification);
  const Skin& skin = model.skin;
  SkinLanes lanes;
  for (auto b = std::size_t(skin.layer_begin[std::size_t(k)]);
       b < std::size_t(skin.layer_begin[std::size_t(k) + 1]); b++) {
    const SkinBatch& batch = skin.batches[b];
    lanes.fetch(batch, n);
    lanes.project(batch, ratio, amplification);
    const int begin = skin.batch_begin[b], count = skin.batch_begin[b + 1] - begin;
    for (int i = 0; i < count; i++) {
      if (state.skin_cut[std::size_t(begin + i)]) continue;
      for (int q = 0; q < 3; q++) {
        const int slot = batch.vertex[q][i];
        n.ux[slot] += lanes.x[3 * q][i], n.uy[slot] += lanes.x[3 * q + 1][i],
            n.uz[slot] += lanes.x[3 * q + 2][i];
      }
    }
  }
}

}  // namespace

void sweep_pbd(const Exec& exec, const Model& model, State& state) {
  const NodeArrays nodes = node_arrays(model, state);
  const SweepRow sweep_row{model, nodes, state.row_cut.data(), rest_edges(model.lattice)};
  const bool with_skin = !model.skin.triangles.empty();
  sweep_slabs(exec, model.lattice.size.z, [&](int k) {
    for (int j = 0; j < model.lattice.size.y; j++) sweep_row(j, k);
    if (with_skin && k + 1 < model.lattice.size.z) project_skin_layer(model, state, nodes, k);
  });
}

}  // namespace turgor::lattice

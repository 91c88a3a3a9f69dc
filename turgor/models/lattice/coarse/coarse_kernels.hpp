// The step of the smooth part (coarse_correction.hpp) as loops over plain pointers: a thread a node finds the
// force that is left over and goes the way at the end; in between are sums, of few terms a thread, in an
// order that follows from the space alone. The factors of the stiffness come as their inverses, whose rows
// need not wait for each other. The same source runs on a CPU (CpuRun, ShuffledRun) and on a GPU; on a CPU
// correct_smooth_part is faster and means the same.
#pragma once

#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/solver/vbd_kernels.hpp"

namespace turgor::lattice {

/// As many nodes, or terms of a sum, are added up by one thread.
constexpr int kAddedTogether = 64;

struct SparseTerm {
  int column = 0;
  float value = 0;
};
/// A sparse matrix by rows, each of them in pieces of at most kAddedTogether terms.
struct SparseRows {
  std::vector<SparseTerm> terms;
  std::vector<int> piece_begin{0};  // in `terms`, and the end
  std::vector<int> row_begin{0};    // in pieces, and the end
};
struct SparseView {
  const SparseTerm* terms;
  const int *piece_begin, *row_begin;
  int pieces, rows;
};

/// Nodes and copies that follow one block.
struct Stretch {
  int block = 0, begin = 0, end = 0;  // CoarseLists::followers
};

/// A coarse space as the loops want it.
struct CoarseLists {
  std::vector<CoarseBlock> blocks;  // of the space; then, for nodes by themselves, blocks with one corner
  std::vector<int> followers;       // slots, or slot_count + number of a copy, block by block
  std::vector<Stretch> stretches;   // of at most kAddedTogether followers
  std::vector<int> slot_of_virtual_node;
  SparseRows to_unknowns;  // from eight corners of every stretch
  SparseRows lower;        // L⁻¹, from the numbers of unknowns to those of the factor
  SparseRows upper;        // and back: Lᵀ⁻¹ D⁻¹ [m/N]
  SparseRows to_corners;   // from unknowns
};
CoarseLists coarse_lists(const Model& model, const State& state, const CoarseSpace& space);

/// How far the way is gone.
struct CoarseSearch {
  double slope = 0;  // where it begins [J]
  Real part = 0;     // of the way, in the next move
};

/// The lists on one side of the bus, and room to work in.
struct CoarseView {
  Lattice lattice;
  const CoarseBlock* blocks;
  const int *followers, *slot_of_virtual_node;
  const Stretch* stretches;
  int stretch_count;
  SparseView to_unknowns, lower, upper, to_corners;
  Vec3 *forces, *virtual_node_forces;  // by slot, by copy [N]
  double* corner_sums;                 // three numbers each, by stretch and corner [N]
  double* piece_sums;                  // three numbers a piece, of whichever matrix has the most
  double *wanted, *halfway, *way;      // three numbers an unknown [N], [N], [m]
  double* slopes;                      // by SumSlope
  float* corners;                      // three numbers a corner [m]
  CoarseSearch* search;                // one

  TURGOR_HD int numbers() const { return lower.rows; }
  TURGOR_HD int slots() const { return slot_count(lattice); }
  /// Where a follower is between the corners of its block.
  TURGOR_HD Vec3 place(const Stretch& stretch, int node) const {
    const int slot = node < slots() ? node : slot_of_virtual_node[node - slots()];
    return place_in_block(blocks[stretch.block], slot_node(lattice, slot));
  }
};

// ---------------------------------------------------------------- forces that are left over

template <Elements kElements>
struct ComputeResidual {
  VbdView v;
  Vec3* forces;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.body.slot(n);
    if (!v.body.moves(s)) return;
    const Real dt = v.inertia.dt;
    forces[s] = NodeForces<kElements>{v}(s).f +
                (v.inertia(s) - v.body.nodes.u(s)) * (1 / (dt * dt * v.body.nodes.w[s]));
  }
};
struct ComputeVirtualNodeResidual {
  VbdView v;
  Vec3* forces;

  TURGOR_HD void operator()(std::size_t n) const {
    const ElementNode& copy = v.virtual_nodes[n];
    forces[copy.corner - v.body.slots] = v.parts.gather(copy).f;
  }
};

// ---------------------------------------------------------------- between nodes and unknowns

/// What a stretch asks of one corner of its block.
struct SumStretch {
  CoarseView c;

  TURGOR_HD void operator()(std::size_t n) const {
    const Stretch stretch = c.stretches[n / 8];
    Vec3 sum;
    for (int f = stretch.begin; f < stretch.end; f++) {
      const int node = c.followers[f];
      const Vec3 force = node < c.slots() ? c.forces[node] : c.virtual_node_forces[node - c.slots()];
      sum += force * corner_weight(c.place(stretch, node), int(n % 8));
    }
    for (int axis = 0; axis < 3; axis++) c.corner_sums[3 * n + std::size_t(axis)] = double(sum[axis]);
  }
};

/// A matrix times a vector of which every entry is kWidth numbers: first its pieces, then its rows of pieces.
template <std::size_t kWidth>
struct MultiplyPiece {
  SparseView matrix;
  const double* in;
  double* out;

  TURGOR_HD void operator()(std::size_t n) const {
    double sum[kWidth] = {};
    for (int t = matrix.piece_begin[n]; t < matrix.piece_begin[n + 1]; t++)
      for (std::size_t i = 0; i < kWidth; i++)
        sum[i] += double(matrix.terms[t].value) * in[kWidth * std::size_t(matrix.terms[t].column) + i];
    for (std::size_t i = 0; i < kWidth; i++) out[kWidth * n + i] = sum[i];
  }
};
template <std::size_t kWidth, class Out>
struct AddFragments {
  SparseView matrix;
  const double* in;
  Out* out;

  TURGOR_HD void operator()(std::size_t row) const {
    double sum[kWidth] = {};
    for (int p = matrix.row_begin[row]; p < matrix.row_begin[row + 1]; p++)
      for (std::size_t i = 0; i < kWidth; i++) sum[i] += in[kWidth * std::size_t(p) + i];
    for (std::size_t i = 0; i < kWidth; i++) out[kWidth * row + i] = Out(sum[i]);
  }
};
template <std::size_t kWidth, class Run, class Out>
void multiply_with(const Run& run, const SparseView& matrix, const double* in, double* piece_sums, Out* out) {
  run(std::size_t(matrix.pieces), MultiplyPiece<kWidth>{matrix, in, piece_sums});
  run(std::size_t(matrix.rows), AddFragments<kWidth, Out>{matrix, piece_sums, out});
}

/// Nodes and copies go the part of the way that is sought.
struct MoveFollower {
  CoarseView c;
  NodeArrays nodes;
  VirtualNodeShift* virtual_nodes;

  TURGOR_HD void operator()(std::size_t n) const {
    const Stretch stretch = c.stretches[n / kAddedTogether];
    const int f = stretch.begin + int(n % kAddedTogether);
    if (f >= stretch.end || c.search->part == 0) return;
    const int node = c.followers[f];
    const Vec3 place = c.place(stretch, node);
    Vec3 way;
    for (int corner = 0; corner < 8; corner++) {
      const float* at = c.corners + 3 * c.blocks[stretch.block].corner[std::size_t(corner)];
      way += Vec3{at[0], at[1], at[2]} * corner_weight(place, corner);
    }
    way = way * c.search->part;
    if (node < c.slots()) {
      nodes.ux[node] += way.x, nodes.uy[node] += way.y, nodes.uz[node] += way.z;
    } else {
      VirtualNodeShift& copy = virtual_nodes[node - c.slots()];
      copy = {copy.x + way.x, copy.y + way.y, copy.z + way.z};
    }
  }
};

// ---------------------------------------------------------------- how far

/// What the forces do along some of the way.
struct SumSlope {
  CoarseView c;

  TURGOR_HD static int count(const CoarseView& c) {
    return (c.numbers() + kAddedTogether - 1) / kAddedTogether;
  }
  TURGOR_HD void operator()(std::size_t n) const {
    const int begin = int(n) * kAddedTogether,
              end = begin + kAddedTogether < c.numbers() ? begin + kAddedTogether : c.numbers();
    double sum = 0;
    for (int i = begin; i < end; i++) sum += c.wanted[i] * c.way[i];
    c.slopes[n] = sum;
  }
  TURGOR_HD static double all(const CoarseView& c) {
    double sum = 0;
    for (int n = 0; n < count(c); n++) sum += c.slopes[n];
    return sum;
  }
};
/// All of the way first, where it leads down.
struct BeginSearch {
  CoarseView c;
  TURGOR_HD void operator()(std::size_t) const {
    const double slope = SumSlope::all(c);
    *c.search = {slope, slope > 0 ? Real(1) : Real(0)};
  }
};
/// And from there to where the slope is nil.
struct EndSearch {
  CoarseView c;
  TURGOR_HD void operator()(std::size_t) const {
    const double slope = c.search->slope;
    if (slope > 0) c.search->part = Real(part_of_way(slope, SumSlope::all(c)) - 1);
  }
};

template <class Run>
void find_wanted_with(const Run& run, const VbdView& v, const CoarseView& c) {
  with_elements(v, [&](auto of) { run(v.body.count(), ComputeResidual<of()>{v, c.forces}); });
  run(std::size_t(v.virtual_nodes_of.begin[kColorCount]),
      ComputeVirtualNodeResidual{v, c.virtual_node_forces});
  run(8 * std::size_t(c.stretch_count), SumStretch{c});
  multiply_with<3>(run, c.to_unknowns, c.corner_sums, c.piece_sums, c.wanted);
}
/// correct_smooth_part.
template <class Run>
void correct_smooth_part_with(const Run& run, const VbdView& v, const CoarseView& c) {
  const MoveFollower move{c, v.body.nodes, v.parts.virtual_nodes};
  const std::size_t followers = std::size_t(c.stretch_count) * kAddedTogether;
  find_wanted_with(run, v, c);
  multiply_with<1>(run, c.lower, c.wanted, c.piece_sums, c.halfway);
  multiply_with<1>(run, c.upper, c.halfway, c.piece_sums, c.way);
  multiply_with<3>(run, c.to_corners, c.way, c.piece_sums, c.corners);
  run(std::size_t(SumSlope::count(c)), SumSlope{c});
  run(1, BeginSearch{c});
  run(followers, move);
  find_wanted_with(run, v, c);
  run(std::size_t(SumSlope::count(c)), SumSlope{c});
  run(1, EndSearch{c});
  run(followers, move);
}

}  // namespace turgor::lattice

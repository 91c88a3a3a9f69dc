// Kernels of the coarse correction on plain pointers (coarse_correction.hpp). The residual and the
// prolongation use one thread per node. The sums between them have few terms per thread, in an order fixed by
// the space. The factor is stored as inverse matrices, whose rows can be multiplied in parallel. The same
// source runs on the CPU (CpuRun, ShuffledRun) and on a GPU. On a CPU, apply_coarse_correction is faster and
// gives the same result up to rounding.
#pragma once

#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/coarse/secant_search.hpp"
#include "turgor/models/lattice/solver/vbd_kernels.hpp"

namespace turgor::lattice {

/// Largest number of nodes, or of terms of a sum, that one thread adds.
constexpr int kTermsPerThread = 64;

struct SparseTerm {
  int column = 0;
  float value = 0;
};
/// Sparse matrix by rows; each row is split into segments of at most kTermsPerThread terms.
struct SparseRows {
  std::vector<SparseTerm> terms;
  std::vector<int> segment_begin{0};  // by segment, and the end: indices into `terms`
  std::vector<int> row_begin{0};      // by row, and the end: indices of segments
};
struct SparseView {
  const SparseTerm* terms;
  const int *segment_begin, *row_begin;
  int segments, rows;
};

/// Nodes and virtual nodes that are interpolated from the same block.
struct Chunk {
  int block = 0, begin = 0, end = 0;  // range of CoarseLists::fine_nodes
};

/// Coarse space as index lists and sparse matrices for the kernels.
struct CoarseLists {
  std::vector<CoarseBlock>
      blocks;  // blocks of the space, then one pseudo-block per row, whose corners are all that row
  std::vector<int> fine_nodes;  // by block: slots, or slot_count + index of a virtual node
  std::vector<Chunk> chunks;    // each with at most kTermsPerThread nodes
  std::vector<int> slot_of_virtual_node;
  SparseRows to_unknowns;  // restriction from the eight corners of every chunk to unknowns
  SparseRows lower;        // L⁻¹, from unknowns to rows of the factor
  SparseRows upper;        // L⁻ᵀ D⁻¹, from rows of the factor to unknowns [m/N]
  SparseRows to_corners;   // prolongation from unknowns to corners
};
CoarseLists coarse_lists(const Model& model, const CutElements& elements, std::size_t virtual_nodes,
                         const CoarseSpace& space);

/// Pointers to lists and workspaces in host or device memory.
struct CoarseView {
  Lattice lattice;
  const CoarseBlock* blocks;
  const int *fine_nodes, *slot_of_virtual_node;
  const Chunk* chunks;
  int chunk_count;
  SparseView to_unknowns, lower, upper, to_corners;
  Vec3 *forces, *virtual_node_forces;  // residual by slot, and by virtual node [N]
  double* corner_sums;                 // three components per chunk and corner [N]
  double* segment_sums;  // workspace of a matrix product: three components per segment of the largest matrix
  double *restricted_residual, *intermediate, *correction;  // three components per unknown [N] [N] [m]
  double* slopes;                                           // partial sums of SumSlope, one per thread [J]
  float* corners;        // displacement of corners, three components each [m]
  SecantSearch* search;  // a single object

  TURGOR_HD int numbers() const { return lower.rows; }
  TURGOR_HD int slots() const { return slot_count(lattice); }
  /// Local coordinates of a node in the block of its chunk.
  TURGOR_HD Vec3 position(const Chunk& chunk, int node) const {
    const int slot = node < slots() ? node : slot_of_virtual_node[node - slots()];
    return position_in_block(blocks[chunk.block], slot_node(lattice, slot));
  }
};

// ---------------------------------------------------------------- residual forces

template <Elements kElements>
struct ComputeResidual {
  VbdView v;
  Vec3* forces;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.body.slot(n);
    if (!v.body.moves(s) || v.is_listed[s]) return;
    const int parity = s / v.body.half & 1;
    forces[s] = plain_system<kElements>(v, v.rules.block[parity], v.rules.neighbors[parity], s).f +
                v.inertia.force(s, v.body.nodes.u(s));
  }
};
template <Elements kElements>
struct ComputeListedResidual {
  VbdView v;
  Vec3* forces;

  TURGOR_HD void operator()(std::size_t n) const {
    const int s = v.listed[n];
    if (!v.body.moves(s)) return;
    forces[s] = NodeForces<kElements>{v}(s).f + v.inertia.force(s, v.body.nodes.u(s));
  }
};
struct ComputeVirtualNodeResidual {
  VbdView v;
  Vec3* forces;

  TURGOR_HD void operator()(std::size_t n) const {
    const ElementNode& virtual_node = v.virtual_nodes[n];
    forces[virtual_node.corner - v.body.slots] = v.cut_elements.gather(virtual_node).f;
  }
};

// ---------------------------------------------------------------- restriction and prolongation

/// Restricts the residual of a chunk to one corner of its block.
struct RestrictChunk {
  CoarseView c;

  TURGOR_HD void operator()(std::size_t n) const {
    const Chunk chunk = c.chunks[n / 8];
    Vec3 sum;
    for (int f = chunk.begin; f < chunk.end; f++) {
      const int node = c.fine_nodes[f];
      const Vec3 force = node < c.slots() ? c.forces[node] : c.virtual_node_forces[node - c.slots()];
      sum += force * corner_weight(c.position(chunk, node), int(n % 8));
    }
    for (int axis = 0; axis < 3; axis++) c.corner_sums[3 * n + std::size_t(axis)] = double(sum[axis]);
  }
};

/// Matrix–vector product for vectors with kWidth components per entry: first sums of segments, then sums of
/// rows.
template <std::size_t kWidth>
struct MultiplySegment {
  SparseView matrix;
  const double* in;
  double* out;

  TURGOR_HD void operator()(std::size_t n) const {
    double sum[kWidth] = {};
    for (int t = matrix.segment_begin[n]; t < matrix.segment_begin[n + 1]; t++)
      for (std::size_t i = 0; i < kWidth; i++)
        sum[i] += double(matrix.terms[t].value) * in[kWidth * std::size_t(matrix.terms[t].column) + i];
    for (std::size_t i = 0; i < kWidth; i++) out[kWidth * n + i] = sum[i];
  }
};
template <std::size_t kWidth, class Out>
struct SumSegments {
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
void multiply_with(const Run& run, const SparseView& matrix, const double* in, double* segment_sums,
                   Out* out) {
  run(std::size_t(matrix.segments), MultiplySegment<kWidth>{matrix, in, segment_sums});
  run(std::size_t(matrix.rows), SumSegments<kWidth, Out>{matrix, segment_sums, out});
}

/// Adds SecantSearch::change times the prolongated correction to a node or virtual node.
struct ProlongateNode {
  CoarseView c;
  NodeArrays nodes;
  VirtualNodeDisplacement* virtual_nodes;

  TURGOR_HD void operator()(std::size_t n) const {
    const Chunk chunk = c.chunks[n / kTermsPerThread];
    const int f = chunk.begin + int(n % kTermsPerThread);
    if (f >= chunk.end || c.search->change == 0) return;
    // interpolated correction
    const int node = c.fine_nodes[f];
    const auto at_row = [this](int row) {
      const float* at = c.corners + 3 * row;
      return Vec3{at[0], at[1], at[2]};
    };
    const Vec3 correction =
        interpolate(c.blocks[chunk.block], c.position(chunk, node), at_row) * Real(c.search->change);
    // add to the node or virtual node
    if (node < c.slots())
      nodes.ux[node] += correction.x, nodes.uy[node] += correction.y, nodes.uz[node] += correction.z;
    else
      virtual_nodes[node - c.slots()].move(correction);
  }
};

// ---------------------------------------------------------------- step length

/// Partial sum of restricted residual · correction.
struct SumSlope {
  CoarseView c;

  TURGOR_HD static int count(const CoarseView& c) {
    return (c.numbers() + kTermsPerThread - 1) / kTermsPerThread;
  }
  TURGOR_HD void operator()(std::size_t n) const {
    const int begin = int(n) * kTermsPerThread,
              end = begin + kTermsPerThread < c.numbers() ? begin + kTermsPerThread : c.numbers();
    double sum = 0;
    for (int i = begin; i < end; i++) sum += c.restricted_residual[i] * c.correction[i];
    c.slopes[n] = sum;
  }
  TURGOR_HD static double all(const CoarseView& c) {
    double sum = 0;
    for (int n = 0; n < count(c); n++) sum += c.slopes[n];
    return sum;
  }
};
struct BeginSearch {
  CoarseView c;
  TURGOR_HD void operator()(std::size_t) const { c.search->begin(SumSlope::all(c)); }
};
struct EndSearch {
  CoarseView c;
  TURGOR_HD void operator()(std::size_t) const { c.search->end(SumSlope::all(c)); }
};

/// Computes the residual at nodes and virtual nodes, and restricts it to the unknowns.
template <class Run>
void restrict_residual_with(const Run& run, const VbdView& v, const CoarseView& c) {
  with_elements(v, [&](auto of) {
    run(v.body.count(), ComputeResidual<of()>{v, c.forces});
    run(std::size_t(v.listed_of_color.begin[kColorCount]), ComputeListedResidual<of()>{v, c.forces});
  });
  run(std::size_t(v.virtual_nodes_of_color.begin[kColorCount]),
      ComputeVirtualNodeResidual{v, c.virtual_node_forces});
  run(8 * std::size_t(c.chunk_count), RestrictChunk{c});
  multiply_with<3>(run, c.to_unknowns, c.corner_sums, c.segment_sums, c.restricted_residual);
}
/// Phases of a correction (secant_search.hpp) by kernels.
template <class Run>
struct CorrectionKernels {
  const Run& run;
  const VbdView& v;
  const CoarseView& c;

  void restrict_residual() const { restrict_residual_with(run, v, c); }
  void solve() const {
    multiply_with<1>(run, c.lower, c.restricted_residual, c.segment_sums, c.intermediate);
    multiply_with<1>(run, c.upper, c.intermediate, c.segment_sums, c.correction);
    multiply_with<3>(run, c.to_corners, c.correction, c.segment_sums, c.corners);
  }
  void begin_search() const { sum_slope(), run(1, BeginSearch{c}); }
  void end_search() const { sum_slope(), run(1, EndSearch{c}); }
  void sum_slope() const { run(std::size_t(SumSlope::count(c)), SumSlope{c}); }
  void prolongate() const {
    run(std::size_t(c.chunk_count) * kTermsPerThread,
        ProlongateNode{c, v.body.nodes, v.cut_elements.virtual_nodes});
  }
};

}  // namespace turgor::lattice

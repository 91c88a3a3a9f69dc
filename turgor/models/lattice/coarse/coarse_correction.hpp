// Two-level correction for VBD. Sweeps reduce smooth error slowly, so the smooth component of the residual is
// solved directly in a Galerkin coarse space. The space consists of blocks of cells with trilinear
// displacements. Block size doubles from level to level until few corners remain. Corners are not shared
// across a cut, and blocks that a blade crossed are refined to single nodes. The coarse operator is assembled
// for the undeformed body and factored again after cuts. A secant step length prevents an increase of energy
// up to second order. [Dick, Georgii, Westermann 2011 for cuts]
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/model/runs.hpp"

namespace turgor::lattice {

/// Level and index of an aggregate in the hierarchy (coarse_levels.hpp).
struct AggregateIndex {
  int level = -1, aggregate = -1;

  friend bool operator==(const AggregateIndex&, const AggregateIndex&) = default;
};

/// Block of cells whose displacement is interpolated trilinearly from its eight corners.
struct CoarseBlock {
  Int3 low;      // node at its lowest corner
  int size = 0;  // cells per side
  AggregateIndex leaf;
  std::array<int, 8> corner{};  // row of each corner in CoarseSpace::row_begin
};

/// Local coordinates of a node in a block, clamped to [0, 1].
TURGOR_HD inline Vec3 position_in_block(const CoarseBlock& block, Int3 node) {
  const Vec3 t = Vec3(node - block.low) * (1 / float(block.size));
  const auto between = [](float a) { return std::min(1.0f, std::max(0.0f, a)); };
  return {between(t.x), between(t.y), between(t.z)};
}
/// Trilinear weight of a corner at a local position.
TURGOR_HD inline float corner_weight(Vec3 position, int corner) {
  const float x = corner & 1 ? position.x : 1 - position.x, y = corner & 2 ? position.y : 1 - position.y,
              z = corner & 4 ? position.z : 1 - position.z;
  return x * (y * z);
}
/// Trilinear interpolation at a local position. `at_corner(row)`: displacement of a corner [m].
template <class AtCorner>
TURGOR_HD inline Vec3 interpolate(const CoarseBlock& block, Vec3 position, const AtCorner& at_corner) {
  Vec3 displacement;
  for (int c = 0; c < 8; c++)
    displacement += at_corner(block.corner[std::size_t(c)]) * corner_weight(position, c);
  return displacement;
}
inline std::array<float, 8> corner_weights(const CoarseBlock& block, Int3 node) {
  const Vec3 position = position_in_block(block, node);
  std::array<float, 8> weights;
  for (int c = 0; c < 8; c++) weights[std::size_t(c)] = corner_weight(position, c);
  return weights;
}

/// One term of the interpolation Σ weight · unknown of a corner or single node.
struct CoarseTerm {
  int unknown = 0;
  float weight = 0;
};

/// Run of consecutive nodes of a half row that are interpolated from the same block, or a single node.
struct ProlongationRun {
  Int3 first;               // coordinates of the first node
  int slot = 0, count = 0;  // slot of the first node; number of nodes
  int source = 0;           // value of CoarseSpace::interpolation for these nodes
};

/// Trilinear weights along a run in a block, which is linear there. Corners 2 n and 2 n + 1 share side[n].
struct RunWeights {
  std::array<Real, 4> side{};
  Real from = 0, per_step = 0;  // unclamped local coordinate of the first node; step per node

  Real coordinate(int n) const { return std::min(Real(1), std::max(Real(0), from + Real(n) * per_step)); }
};

/// Edge spring between two neighbor nodes that is not an edge of any cell (cells.hpp).
struct UncoveredEdge {
  int slot = 0, family = 0;
};

/// Factored coarse operator Πᵀ L D Lᵀ Π with a permutation Π. Floats suffice: the solution is only a descent
/// direction, which the step length scales.
struct CoarseFactor {
  std::vector<int> order;               // elimination order of the unknowns' numbers
  std::vector<float> inverse_diagonal;  // 1/D [m/N]
  std::vector<std::uint32_t> column;    // by column of L, and the end: indices into `row` and `value`
  std::vector<std::uint16_t> row;       // row indices below the diagonal
  std::vector<float> value;             // [1]

  std::vector<double> solve(std::span<const double> forces) const;
};

/// Points that stitches couple (coupled_points.hpp).
struct CoupledPoints;

/// Prolongation from the unknowns to nodes and virtual nodes, and the coarse operator.
struct CoarseSpace {
  std::size_t version = 0;  // cut_version of the state that the space was built from
  double dt = 0;            // time step that the operator was built for [s]
  int unknowns = 0;         // number of unknowns, each with three components
  std::vector<CoarseBlock> blocks;
  std::vector<int>
      row_begin;  // by row, and the end: indices into `terms`. A row is a corner or a single node.
  std::vector<CoarseTerm> terms;      // row by row
  aligned_vector<int> interpolation;  // by slot, then by virtual node: kFixed, the index of a block, or −2 −
                                      // row for a single node
  std::vector<ProlongationRun> runs;    // all nodes that are not fixed, in slot order
  std::vector<RunWeights> run_weights;  // by run; of single nodes unused
  std::vector<int> runs_begin;          // by layer, and the end: indices into `runs`
  std::vector<int> outside;  // nodes of loose edges that are interpolated from a block outside of which they
                             // lie, ascending
  std::vector<UncoveredEdge> loose;              // edges that no cell contains
  Runs cells;                                    // runs of cells with a free node
  CoarseFactor factor;                           // [N/m]
  std::shared_ptr<const CoupledPoints> coupled;  // null: no stitch couples points of the body

  static constexpr int kFixed = -1;
  std::span<const ProlongationRun> runs_of(int k) const {
    const auto begin = std::size_t(runs_begin[std::size_t(k)]),
               end = std::size_t(runs_begin[std::size_t(k) + 1]);
    return std::span(runs).subspan(begin, end - begin);
  }
  /// Weights of the first run of a layer.
  const RunWeights* weights_of(int k) const { return run_weights.data() + runs_begin[std::size_t(k)]; }
};

/// Builds the space of the body with its current cuts. The space has no unknowns if no node can move or if
/// there would be too many.
std::shared_ptr<const CoarseSpace> make_coarse_space(const Model& model, const State& state, double dt,
                                                     const Exec& exec = Exec(1));

/// Residual forces at the nodes of one layer, along the lattice axes [N]. Indexed by slot.
struct LayerForces {
  const VecField& field;
  int shift = 0;

  Vec3 operator[](int slot) const { return field[std::size_t(slot + shift)]; }
};
/// Number of chunks of layers that are processed in parallel. It is constant, so that results do not depend
/// on the number of threads.
constexpr int kLayerChunks = 8;
/// Calls visit(chunk, layer, forces) for every layer of nodes. Layers of a chunk are visited in order.
/// Afterwards workspace.virtual_nodes contains the residual at virtual nodes.
void visit_residual_forces(const Exec& exec, const Model& model, State& state, const CoarseSpace& space,
                           const Inputs& inputs, double dt, ResidualWorkspace& workspace,
                           const std::function<void(int, int, LayerForces)>& visit);

/// True if the model's parameters permit a coarse space. prepare_coarse_space decides for each step.
bool supports_coarse_space(const Model& model);
/// Rebuilds the space after cuts or for a longer time step. Returns true if this step can use it. Returns
/// false without supports_coarse_space, for a body at rest, or for a much shorter time step.
/// Also returns false if a rebuild is due while a blade still cuts. The operator has the couplings of
/// Inputs::springs. Contacts need the host: kernels of corrections have none.
bool prepare_coarse_space(const Model& model, State& state, const Inputs& inputs, double dt,
                          const Exec& exec = Exec(1));
/// Result of a correction.
struct CoarseStep {
  double displacement = 0;  // largest displacement of an unknown [m]
  double step_length = 0;   // 1 = the operator has the stiffness of the body along the correction
};
/// Applies one coarse correction between sweeps: a Newton step in the coarse space with a secant step length.
CoarseStep apply_coarse_correction(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                                   double dt);

/// Memory of a space including its factor [bytes].
std::size_t memory_bytes(const CoarseSpace& space);

}  // namespace turgor::lattice

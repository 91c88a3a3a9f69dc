// A coarse space beside the sweeps: what a few sweeps cannot carry through a body, the smooth part of what a
// frame is short of, is solved for at once. Blocks of cells, halved until few enough nodes are left, move by
// what is trilinear in their corners; tissue that a blade parted has corners of its own on each side, and the
// blocks that it went through are refined down to single nodes. The space's stiffness is that of
// the body in the CT, factored once for every cut; a search along the way makes the step never raise the
// energy by more than what is not linear in it. [Galerkin; Dick, Georgii and Westermann 2011 for cuts]
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/model/runs.hpp"

namespace turgor::lattice {

/// Where a block is among the levels of blocks in blocks (coarse_levels.hpp).
struct Leaf {
  int level = -1, grain = -1;

  friend bool operator==(const Leaf&, const Leaf&) = default;
};

/// A block that moves by what is trilinear in its eight corners.
struct CoarseBlock {
  Int3 low;      // its lowest node
  int size = 0;  // steps a side
  Leaf leaf;
  std::array<int, 8> corner{};  // rows of CoarseSpace::row_begin
};

/// Where a node is between the corners of a block, in [0, 1]; outside of it, where the block is nearest.
TURGOR_HD inline Vec3 place_in_block(const CoarseBlock& block, Int3 node) {
  const Vec3 t = Vec3(node - block.low) * (1 / float(block.size));
  const auto between = [](float a) { return std::min(1.0f, std::max(0.0f, a)); };
  return {between(t.x), between(t.y), between(t.z)};
}
/// How much of a corner's motion there is at a place.
TURGOR_HD inline float corner_weight(Vec3 place, int corner) {
  const float x = corner & 1 ? place.x : 1 - place.x, y = corner & 2 ? place.y : 1 - place.y,
              z = corner & 4 ? place.z : 1 - place.z;
  return x * (y * z);
}
inline std::array<float, 8> corner_weights(const CoarseBlock& block, Int3 node) {
  const Vec3 place = place_in_block(block, node);
  std::array<float, 8> weights;
  for (int c = 0; c < 8; c++) weights[std::size_t(c)] = corner_weight(place, c);
  return weights;
}

/// What a corner, or a node beside a blade's end, is of the unknowns: Σ weight · unknown.
struct CoarseTerm {
  int unknown = 0;
  float weight = 0;
};

/// Nodes of one parity in a row, all of which follow the same block; or one that is by itself.
struct FollowRun {
  Int3 first;               // the first of these nodes
  int slot = 0, count = 0;  // its slot, and how many follow each other
  int to = 0;               // as CoarseSpace::follows
};

/// A spring between two neighbouring nodes that no cell holds.
struct LooseEdge {
  int slot = 0, family = 0;
};

/// A stiffness, factored as Pᵀ L D Lᵀ P. What a step needs of it is a way down, which a search along it
/// scales: floats are enough.
struct CoarseFactor {
  std::vector<int> order;             // which unknown comes where
  std::vector<float> mobility;        // 1/D [m/N]
  std::vector<std::uint32_t> column;  // of L, in `row` and `value`; one more than there are columns
  std::vector<std::uint16_t> row;     // below the diagonal, by column
  std::vector<float> value;           // [1]

  std::vector<double> solve(std::span<const double> forces) const;
};

/// How nodes and copies follow the unknowns, and what moving these costs.
struct CoarseSpace {
  std::size_t version = 0;  // cut_version of the state that it was made of
  double dt = 0;            // of the steps [s]
  int unknowns = 0;         // of three numbers each
  std::vector<CoarseBlock> blocks;
  std::vector<int> row_begin;     // of corners, and of nodes by themselves, in `terms`
  std::vector<CoarseTerm> terms;  // row by row
  aligned_vector<int> follows;  // by slot, then by copy: kFixed, a block, or −2 − the row of a node by itself
  std::vector<FollowRun> runs;   // of the nodes among them, in the order of slots
  std::vector<int> runs_begin;   // by layer, and the end
  std::vector<int> outside;      // of these, nodes outside of the block that they follow
  std::vector<LooseEdge> loose;  // edges that no cell holds
  Runs cells;                    // slots of cells with something in them that can move
  CoarseFactor stiffness;        // [N/m]

  static constexpr int kFixed = -1;
  std::span<const FollowRun> runs_of(int k) const {
    const auto begin = std::size_t(runs_begin[std::size_t(k)]),
               end = std::size_t(runs_begin[std::size_t(k) + 1]);
    return std::span(runs).subspan(begin, end - begin);
  }
};

/// Of the body as it is cut now; for a body that nothing can move, without unknowns.
std::shared_ptr<const CoarseSpace> make_coarse_space(const Model& model, const State& state, double dt);

/// The forces that are left over at the nodes of a layer, along the lattice's axes, by slot [N].
struct LayerForces {
  const VecField& field;
  int shift = 0;

  Vec3 operator[](int slot) const { return field[std::size_t(slot + shift)]; }
};
/// Layers are looked at in so many stretches, side by side, whatever the threads.
constexpr int kStretches = 8;
/// Calls see(stretch, layer, forces) for every layer of nodes, those of a stretch in order; afterwards
/// room.copies holds the forces at copies.
void find_left_over(const Exec& exec, const Model& model, State& state, const CoarseSpace& space,
                    const Inputs& inputs, double dt, ResidualWorkspace& room,
                    const std::function<void(int, int, LayerForces)>& see);

/// Could there be a space for it, if not in every step?
bool may_have_coarse_space(const Model& model);
/// Makes the space anew when cuts or longer steps ask for it; while a blade is on its way, or nothing moves,
/// there is none. Is there one that this step can use? Not where contacts press, tissue is springs,
/// or the step is a part of one that the space was made for.
bool prepare_coarse_space(const Model& model, State& state, const Inputs& inputs, double dt);
/// One step in the coarse space, between sweeps: towards the minimum of what is quadratic there, as far along
/// that way as the forces at its end say. Returns how far the unknown that goes farthest went [m].
double apply_coarse_correction(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                               double dt);

/// How much of a way to go whose slope is `before` where it begins, and `after` at its end: to where it would
/// be nil, but not much farther than the end. The numbers of the end may be none.
TURGOR_HD inline double part_of_way(double before, double after) {
  constexpr double kFarthest = 1.5;
  if (!(after - after == 0)) return 0;
  return before > after ? std::min(kFarthest, before / (before - after)) : kFarthest;
}

/// Memory of a space, its factors among it.
std::size_t memory_bytes(const CoarseSpace& space);

}  // namespace turgor::lattice

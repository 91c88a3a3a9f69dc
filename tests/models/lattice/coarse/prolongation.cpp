// Transfer between nodes and the corners of a coarse space by runs, against the weights of each node.
#include "turgor/models/lattice/coarse/prolongation.hpp"

#include <random>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);

struct RandomVectors {
  std::mt19937 random{11};
  std::uniform_real_distribution<double> number{-1, 1};

  Vec3 vec() { return {Real(number(random)), Real(number(random)), Real(number(random))}; }
};

/// A block with an oblique wound, and its coarse space.
struct Space {
  Wounded wounded{0.4, 0.3, 70, solid_params(5, 4, 45)};
  const Model& model = wounded.model;
  State& state = wounded.state;

  Space() {
    scatter(model, state, 0.0005);
    EXPECT_TRUE(prepare_coarse_space(model, state, {}, 1.0 / 60));
  }
  const CoarseSpace& space() const { return *state.workspace.coarse; }
  std::size_t rows() const { return space().row_begin.size() - 1; }
  /// Weight of a row for a node or virtual node at a slot.
  double weight(std::size_t node, int slot, std::size_t row) const {
    const int to = space().interpolation[node];
    if (to == CoarseSpace::kFixed) return 0;
    if (to < 0) return row == std::size_t(-2 - to);
    const CoarseBlock& block = space().blocks[std::size_t(to)];
    const auto weights = corner_weights(block, slot_node(model.anatomy.lattice, slot));
    double sum = 0;
    for (std::size_t c = 0; c < 8; c++) sum += std::size_t(block.corner[c]) == row ? double(weights[c]) : 0;
    return sum;
  }
};

// Runs have every interpolated node once and in order.
TEST(Prolongation, RunsCoverNodesInOrder) {
  const Space s;
  const auto slots = std::size_t(slot_count(s.model.anatomy.lattice));
  std::vector<int> found(slots, CoarseSpace::kFixed);
  int last = -1, by_itself = 0;
  for (const ProlongationRun& run : s.space().runs) {
    EXPECT_GT(run.slot, last);
    EXPECT_EQ(slot_node(s.model.anatomy.lattice, run.slot), run.first);
    for (int n = 0; n < run.count; n++) found[std::size_t(run.slot + n)] = run.source;
    last = run.slot + run.count - 1, by_itself += run.source < 0;
  }
  EXPECT_GT(by_itself, 10) << "near the blade's ends";
  EXPECT_TRUE(std::equal(found.begin(), found.end(), s.space().interpolation.begin()));
}

// Restriction sums the forces at nodes with their weights.
TEST(Prolongation, RestrictionMatchesWeights) {
  const Space s;
  RandomVectors random;
  VecField forces;
  forces.resize(s.model.anatomy.inverse_mass.size());
  for (std::size_t n = 0; n < forces.x.size(); n++) forces.set(n, random.vec());
  std::vector<Vec3d> sums(s.rows());
  for (int k = 0; k < s.model.anatomy.lattice.size.z; k++) restrict_layer(s.space(), k, {forces}, sums);
  for (std::size_t row = 0; row < s.rows(); row++) {
    Vec3d sum;
    for (std::size_t n = 0; n < forces.x.size(); n++) sum += Vec3d(forces[n]) * s.weight(n, int(n), row);
    EXPECT_LT(norm(sums[row] - sum), 1e-4) << "row " << row;
  }
}

// Nodes and virtual nodes move by the weighted corrections of their corners.
TEST(Prolongation, NodesFollowCorners) {
  Space s;
  RandomVectors random;
  std::vector<Vec3> corrections(s.rows());
  for (Vec3& displacement : corrections) displacement = random.vec() * Real(0.001);
  const State before = s.state;
  prolongate(kTwo, s.model, s.state, corrections);
  const auto expected = [&](std::size_t node, int slot) {
    Vec3d displacement;
    for (std::size_t row = 0; row < s.rows(); row++)
      displacement += Vec3d(corrections[row]) * s.weight(node, slot, row);
    return displacement;
  };
  for (std::size_t n = 0; n < before.motion.u.x.size(); n++)
    EXPECT_LT(norm(Vec3d(s.state.motion.u[n] - before.motion.u[n]) - expected(n, int(n))), 1e-8)
        << "slot " << n;
  const int slots = slot_count(s.model.anatomy.lattice);
  EXPECT_GT(s.state.cut_elements.virtual_nodes.size(), 10u);
  for (const ElementNode& copy : s.state.cut_elements.virtual_nodes) {
    const auto c = std::size_t(copy.corner - slots);
    const VirtualNodeDisplacement &from = before.motion.virtual_u[c], &to = s.state.motion.virtual_u[c];
    const Vec3d displacement{double(to.x) - from.x, double(to.y) - from.y, double(to.z) - from.z};
    EXPECT_LT(norm(displacement - expected(std::size_t(copy.corner), copy.slot)), 1e-8)
        << "virtual node " << c;
  }
}

}  // namespace
}  // namespace turgor::lattice

// What goes between nodes and the corners of a coarse space, run by run, and by the weights of one node after
// the other.
#include "turgor/models/lattice/coarse/prolongation.hpp"

#include <random>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);

struct Any {
  std::mt19937 random{11};
  std::uniform_real_distribution<double> number{-1, 1};

  Vec3 vec() { return {Real(number(random)), Real(number(random)), Real(number(random))}; }
};

/// A block with a wound aslant, and its space.
struct Space {
  Wounded wounded{0.4, 0.3, 70, solid_params(5, 4, 45)};
  const Model& model = wounded.model;
  State& state = wounded.state;

  Space() {
    scatter(model, state, 0.0005);
    EXPECT_TRUE(prepare_coarse_space(model, state, {}, 1.0 / 60));
  }
  const CoarseSpace& space() const { return *state.coarse; }
  std::size_t rows() const { return space().row_begin.size() - 1; }
  /// How much a node or copy, which lies at a slot, goes with a row.
  double weight(std::size_t node, int slot, std::size_t row) const {
    const int to = space().follows[node];
    if (to == CoarseSpace::kFixed) return 0;
    if (to < 0) return row == std::size_t(-2 - to);
    const CoarseBlock& block = space().blocks[std::size_t(to)];
    const auto weights = corner_weights(block, slot_node(model.lattice, slot));
    double sum = 0;
    for (std::size_t c = 0; c < 8; c++) sum += std::size_t(block.corner[c]) == row ? double(weights[c]) : 0;
    return sum;
  }
};

TEST(lattice_coarse_follow, runs_hold_every_node_that_follows_once_and_in_order) {
  const Space s;
  const auto slots = std::size_t(slot_count(s.model.lattice));
  std::vector<int> found(slots, CoarseSpace::kFixed);
  int last = -1, by_itself = 0;
  for (const FollowRun& run : s.space().runs) {
    EXPECT_GT(run.slot, last);
    EXPECT_EQ(slot_node(s.model.lattice, run.slot), run.first);
    for (int n = 0; n < run.count; n++) found[std::size_t(run.slot + n)] = run.to;
    last = run.slot + run.count - 1, by_itself += run.to < 0;
  }
  EXPECT_GT(by_itself, 10) << "beside the blade's ends";
  EXPECT_TRUE(std::equal(found.begin(), found.end(), s.space().follows.begin()));
}

TEST(lattice_coarse_follow, corners_get_of_the_forces_at_nodes_what_their_weights_say) {
  const Space s;
  Any any;
  VecField forces;
  forces.resize(s.model.inverse_mass.size());
  for (std::size_t n = 0; n < forces.x.size(); n++) forces.set(n, any.vec());
  std::vector<Vec3d> sums(s.rows());
  for (int k = 0; k < s.model.lattice.size.z; k++) add_to_corners(s.space(), k, {forces}, sums);
  for (std::size_t row = 0; row < s.rows(); row++) {
    Vec3d sum;
    for (std::size_t n = 0; n < forces.x.size(); n++) sum += Vec3d(forces[n]) * s.weight(n, int(n), row);
    EXPECT_LT(norm(sums[row] - sum), 1e-4) << "row " << row;
  }
}

TEST(lattice_coarse_follow, nodes_and_copies_go_where_the_corners_around_them_do) {
  Space s;
  Any any;
  std::vector<Vec3> ways(s.rows());
  for (Vec3& way : ways) way = any.vec() * Real(0.001);
  const State before = s.state;
  move_followers(kTwo, s.model, s.state, ways);
  const auto sought = [&](std::size_t node, int slot) {
    Vec3d way;
    for (std::size_t row = 0; row < s.rows(); row++) way += Vec3d(ways[row]) * s.weight(node, slot, row);
    return way;
  };
  for (std::size_t n = 0; n < before.u.x.size(); n++)
    EXPECT_LT(norm(Vec3d(s.state.u[n] - before.u[n]) - sought(n, int(n))), 1e-8) << "slot " << n;
  const int slots = slot_count(s.model.lattice);
  EXPECT_GT(s.state.parts.virtual_nodes.size(), 10u);
  for (const ElementNode& copy : s.state.parts.virtual_nodes) {
    const auto c = std::size_t(copy.corner - slots);
    const VirtualNodeShift &from = before.virtual_nodes[c], &to = s.state.virtual_nodes[c];
    const Vec3d way{double(to.x) - from.x, double(to.y) - from.y, double(to.z) - from.z};
    EXPECT_LT(norm(way - sought(std::size_t(copy.corner), copy.slot)), 1e-8) << "copy " << c;
  }
}

}  // namespace
}  // namespace turgor::lattice

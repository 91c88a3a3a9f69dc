// Rows that later sweeps of a step leave out.
#include "turgor/models/lattice/solver/calm_rows.hpp"

#include <numeric>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"

namespace turgor::lattice {
namespace {

int count_of(const std::vector<std::uint8_t>& marks) {
  return std::accumulate(marks.begin(), marks.end(), 0);
}

// The first sweep takes all rows that are awake. Later ones take those beside motion, at cuts and at springs,
// and those that woke since; steps with contacts take all.
TEST(CalmRows, ChosenBesideMotionCutsAndSprings) {
  Wounded wounded(0.4, 0.3, 70, solid_params(5, 4, 45));
  const Model& model = wounded.model;
  State& state = wounded.state;
  const Lattice& l = model.anatomy.lattice;
  const int rows = int(state.cuts.row_cut.size()), uncut = row_of(model, row_slot(l, 1, 1)),
            late = row_of(model, row_slot(l, l.size.y - 2, 1));
  state.sleep.awake.assign(std::size_t(rows), 1), state.sleep.awake[std::size_t(late)] = 0;
  std::fill(state.cuts.row_cut.begin(), state.cuts.row_cut.end(), std::uint8_t(0));
  CalmRows calm;
  choose_swept_rows(model, state, {}, calm);
  EXPECT_EQ(calm.swept, state.sleep.awake);
  // nothing moved
  choose_swept_rows(model, state, {}, calm);
  EXPECT_EQ(count_of(calm.swept), 0);
  // a row that moved, and one that woke
  calm.stirred[std::size_t(uncut)] = 1, state.sleep.awake[std::size_t(late)] = 1;
  choose_swept_rows(model, state, {}, calm);
  EXPECT_EQ(count_of(calm.swept), 9 + 1);
  EXPECT_EQ(calm.swept[std::size_t(late)], 1);
  // a row at a cut
  state.cuts.row_cut[std::size_t(uncut)] = 1;
  choose_swept_rows(model, state, {}, calm);
  EXPECT_EQ(count_of(calm.swept), 1);
  // rows at a spring
  PointSprings springs;
  springs.all.push_back({.at = {.cell = row_slot(l, l.size.y / 2, l.size.z / 2)}});
  choose_swept_rows(model, state, {.springs = &springs}, calm);
  EXPECT_EQ(count_of(calm.swept), 9 + 1);
  // contacts
  std::vector<NodeContact> contacts(1);
  choose_swept_rows(model, state, {.contacts = contacts}, calm);
  EXPECT_EQ(calm.swept, state.sleep.awake);
}

// A chunk moved if one node moved farther than the distance, or is not finite.
TEST(CalmRows, ChunkMovesWithFarthestNode) {
  Wounded wounded(0.4, 0.3, 70, solid_params(5, 4, 45));
  const NodeArrays nodes = node_arrays(wounded.model, wounded.state);
  const int slot = row_slot(wounded.model.anatomy.lattice, 2, 2);
  ChunkBefore before;
  before.copy(nodes, slot, 7);
  EXPECT_FALSE(before.has_moved(nodes, slot, 7, Real(0)));
  nodes.uy[slot + 6] += Real(1e-5);
  EXPECT_TRUE(before.has_moved(nodes, slot, 7, Real(0.9e-10)));
  EXPECT_FALSE(before.has_moved(nodes, slot, 7, Real(1.1e-10)));
  EXPECT_FALSE(before.has_moved(nodes, slot, 6, Real(0))) << "the node is not in the chunk";
  nodes.uy[slot + 6] = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_TRUE(before.has_moved(nodes, slot, 7, Real(1)));
}

}  // namespace
}  // namespace turgor::lattice

#include "turgor/models/lattice/mechanics/inverted_cells.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"

namespace turgor::lattice {
namespace {

/// A block of 5 × 4 × 3 cells whose points are where `place` takes them.
template <class Place>
InvertedCells folded_in(const Place& place) {
  Params params;
  params.skin.enabled = false;
  const Model model = block_model({.size = {6, 5, 4}, .skin_on_top = false}, params);
  State state = make_state(model);
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 5; j++)
      for (int i = 0; i < 6; i++) {
        const Vec3 x = rest_position(model.lattice, {i, j, k});
        state.u.set(std::size_t(node_slot(model.lattice, {i, j, k})), place(x) - x);
      }
  return find_folded_cells(Exec(2), model, state);
}

TEST(lattice_folded, a_mirrored_block_has_all_its_cells_folded_and_a_turned_one_none) {
  EXPECT_EQ(folded_in([](Vec3 x) { return Vec3{-x.x, x.y, x.z}; }).count, 5 * 4 * 3);
  EXPECT_EQ(folded_in([](Vec3 x) { return Vec3{-x.x, -x.y, x.z}; }).count, 0);
  EXPECT_EQ(folded_in([](Vec3 x) { return Vec3{x.z, x.x, x.y}; }).count, 0);
}

TEST(lattice_folded, where_a_layer_is_pushed_through_the_next_its_cells_are_found) {
  const auto through = [](Vec3 x) { return x.z > 0.011f ? Vec3{x.x, x.y, x.z - 0.009f} : x; };
  const InvertedCells folded = folded_in(through);  // 4 mm cells: the topmost nodes, 12 mm high, go to 3 mm
  EXPECT_EQ(folded.count, 5 * 4);
  EXPECT_EQ(folded.first, (Int3{0, 0, 2}));
}

TEST(lattice_folded, a_cut_says_how_many_cells_lie_below_it) {
  const Model model = block_model({.size = {20, 20, 9}}, {});
  const Vec3d down{0, 0, -1};
  for (const auto& [height, cells] : {std::pair{0.032, 6.0}, {0.010, 2.5}, {0.004, 1.0}}) {
    const double found = cells_below(model, {0.02, 0.03, height}, {0.05, 0.03, height}, down, 6);
    EXPECT_NEAR(found, cells, 0.51) << height << " m above the lowest nodes";
  }
  EXPECT_EQ(cells_below(model, {0.02, 0.03, -0.01}, {0.05, 0.03, -0.01}, down, 3), 0) << "below the body";
}

}  // namespace
}  // namespace turgor::lattice

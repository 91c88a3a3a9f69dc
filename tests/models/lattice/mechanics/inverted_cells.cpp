#include "turgor/models/lattice/mechanics/inverted_cells.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

/// A block of 5 × 4 × 3 cells whose nodes move to `position(rest position)`.
template <class Position>
InvertedCells inverted_after(const Position& position) {
  Params params;
  params.skin.enabled = false;
  const Model model = block_model({.size = {6, 5, 4}, .skin_on_top = false}, params);
  State state = make_state(model);
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 5; j++)
      for (int i = 0; i < 6; i++) {
        const Vec3 x = rest_position(model.anatomy.lattice, {i, j, k});
        state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, {i, j, k})), position(x) - x);
      }
  return find_inverted_cells(Exec(2), model, state);
}

// A reflected block has all cells inverted, a rotated one has none.
TEST(InvertedCells, ReflectionInvertsAllRotationNone) {
  EXPECT_EQ(inverted_after([](Vec3 x) { return Vec3{-x.x, x.y, x.z}; }).count, 5 * 4 * 3);
  EXPECT_EQ(inverted_after([](Vec3 x) { return Vec3{-x.x, -x.y, x.z}; }).count, 0);
  EXPECT_EQ(inverted_after([](Vec3 x) { return Vec3{x.z, x.x, x.y}; }).count, 0);
}

// A layer that is pushed through the next one is found.
TEST(InvertedCells, FindsLayerPushedThrough) {
  const auto through = [](Vec3 x) { return x.z > 0.011f ? Vec3{x.x, x.y, x.z - 0.009f} : x; };
  const InvertedCells inverted =
      inverted_after(through);  // 4 mm cells: the top nodes move from 12 mm to 3 mm height
  EXPECT_EQ(inverted.count, 5 * 4);
  EXPECT_EQ(inverted.first, (Int3{0, 0, 2}));
}

// cells_below counts the cells below a cut, zero outside of the body.
TEST(InvertedCells, CellsBelowCut) {
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

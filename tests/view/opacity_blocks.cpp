#include "turgor/view/opacity_blocks.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

struct Case {
  CtVolume ct;
  OpacityBlocks blocks;
};

// Two balls of bone in air, in a volume whose size is no multiple of the block size.
Case two_balls(int threads) {
  const Grid grid = test::centered_grid({70, 61, 53}, {0.001, 0.001, 0.001}, {});
  CtVolume ct = test::ball_volume(grid, {-0.02, 0.01, 0}, 0.006, 900);
  const CtVolume other = test::ball_volume(grid, {0.022, -0.015, 0.01}, 0.004, 900);
  for (std::size_t i = 0; i < ct.samples.size(); i++)
    ct.samples[i] = std::max(ct.samples[i], other.samples[i]);
  OpacityBlocks blocks = build_opacity_blocks(Exec(threads), ct, Transfer(transfer_points("bone")));
  return {std::move(ct), std::move(blocks)};
}

int distance_at(const OpacityBlocks& b, int i, int j, int k) {
  return b.distance[std::size_t((k * b.size.y + j) * b.size.x + i)];
}

// Every visible sample lies in a visible block.
TEST(OpacityBlocks, VisibleSamplesAreInVisibleBlocks) {
  const auto [ct, blocks] = two_balls(2);
  const Transfer transfer(transfer_points("bone"));
  int visible = 0;
  for (int k = 0; k < ct.grid.size.z; k++) {
    for (int j = 0; j < ct.grid.size.y; j++) {
      for (int i = 0; i < ct.grid.size.x; i++) {
        if (transfer.extinction(ct.at(i, j, k)) == 0) continue;
        visible++;
        EXPECT_EQ(distance_at(blocks, i / kBlock, j / kBlock, k / kBlock), 0);
      }
    }
  }
  EXPECT_GT(visible, 800);
}

// The distance of a block is the Chebyshev distance to the nearest visible block.
TEST(OpacityBlocks, DistanceIsToNearestVisibleBlock) {
  const OpacityBlocks blocks = two_balls(2).blocks;
  std::vector<Int3> visible;
  for (int k = 0; k < blocks.size.z; k++)
    for (int j = 0; j < blocks.size.y; j++)
      for (int i = 0; i < blocks.size.x; i++)
        if (distance_at(blocks, i, j, k) == 0) visible.push_back({i, j, k});
  ASSERT_FALSE(visible.empty());
  for (int k = 0; k < blocks.size.z; k++) {
    for (int j = 0; j < blocks.size.y; j++) {
      for (int i = 0; i < blocks.size.x; i++) {
        int best = 255;
        for (const Int3 v : visible)
          best = std::min(best, std::max({std::abs(v.x - i), std::abs(v.y - j), std::abs(v.z - k)}));
        EXPECT_EQ(distance_at(blocks, i, j, k), best);
      }
    }
  }
}

// One thread and eight threads build the same blocks.
TEST(OpacityBlocks, IndependentOfThreadCount) {
  const OpacityBlocks one = two_balls(1).blocks, eight = two_balls(8).blocks;
  EXPECT_EQ(one.distance, eight.distance);
  for (std::size_t level = 0; level < one.levels.size(); level++)
    EXPECT_EQ(one.levels[level].opaque, eight.levels[level].opaque);
}

// Occupancy is one deep inside a ball and zero far outside.
TEST(OpacityBlocks, OccupancyIsOneInsideZeroOutside) {
  const Grid grid = test::centered_grid({64, 64, 64}, {0.001, 0.001, 0.001}, {});
  const CtVolume ct = test::ball_volume(grid, {}, 0.024, 900);
  const OpacityBlocks blocks = build_opacity_blocks(Exec(1), ct, Transfer(transfer_points("bone")));
  EXPECT_NEAR(occupancy_at(blocks.levels[0], 0, {32, 32, 32}), 1, 0.02);
  EXPECT_NEAR(occupancy_at(blocks.levels[1], 1, {32, 32, 32}), 1, 0.02);
  EXPECT_EQ(occupancy_at(blocks.levels[0], 0, {2, 2, 2}), 0);
  EXPECT_EQ(occupancy_at(blocks.levels[3], 3, {-500, 0, 0}), 0);
}

}  // namespace
}  // namespace turgor

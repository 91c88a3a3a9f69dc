#include "turgor/core/round_ticks.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Ticks are round numbers within the range; an empty or non-finite range has none.
TEST(RoundTicks, RoundValuesWithinRange) {
  EXPECT_EQ(round_ticks(0, 8.3, 6), (std::vector<double>{0, 2, 4, 6, 8}));
  EXPECT_EQ(round_ticks(-1, 1, 5), (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  EXPECT_EQ(round_ticks(100, 900, 5), (std::vector<double>{200, 400, 600, 800}));
  EXPECT_TRUE(round_ticks(1, 1, 5).empty());
  EXPECT_TRUE(round_ticks(0, std::numeric_limits<double>::infinity(), 5).empty());
  EXPECT_TRUE(round_ticks(0, std::numeric_limits<double>::denorm_min(), 5).empty());
}

// A range has two to seven ticks from 1e-290 to 1e300.
TEST(RoundTicks, TwoToSevenOnAnyScale) {
  for (const double scale : {1e-290, 1e-12, 1.0, 7e11, 9e299})
    for (const double shift : {-3.0, 0.0, 0.7}) {
      const std::vector<double> ticks = round_ticks(scale * shift, scale * (shift + 1.3), 5);
      EXPECT_GE(ticks.size(), 2u) << scale;
      EXPECT_LE(ticks.size(), 7u) << scale;
    }
}

}  // namespace
}  // namespace turgor

// Helpers for figures of validations.
#include "app/validation.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Values that are not finite reach the figure, whatever comes before and after them.
TEST(Validation, WidestKeepsValuesThatAreNotFinite) {
  EXPECT_EQ(widest(0.5, 0.2), 0.5);
  EXPECT_EQ(widest(0.5, 0.7), 0.7);
  EXPECT_EQ(narrowest(0.5, 0.2), 0.2);
  EXPECT_EQ(narrowest(0.5, 0.7), 0.5);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity}) {
    EXPECT_EQ(widest(widest(0, bad), 0.2), infinity);
    EXPECT_EQ(narrowest(narrowest(1, bad), 0.2), -infinity);
    EXPECT_TRUE(is_missed({"largest", "", "", widest(0, bad), -1e308, 0.1}));
    EXPECT_TRUE(is_missed({"least", "", "", narrowest(1, bad), 0.7, 1.15}));
  }
}

}  // namespace
}  // namespace turgor

#include "turgor/core/result.hpp"

#include <memory>

#include <gtest/gtest.h>

namespace turgor {
namespace {

Result<int> half(int n) {
  if (n % 2 != 0) return Error{"expected an even number, found " + std::to_string(n)};
  return n / 2;
}

TEST(result, is_a_value_or_a_sentence) {
  EXPECT_TRUE(half(4));
  EXPECT_EQ(*half(4), 2);
  EXPECT_FALSE(half(3));
  EXPECT_EQ(half(3).error().message, "expected an even number, found 3");
}

TEST(result, moves_what_cannot_be_copied) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  const std::unique_ptr<int> taken = *std::move(result);
  EXPECT_EQ(*taken, 5);
}

TEST(result, the_value_of_an_error_stops_with_its_sentence) { EXPECT_DEATH(half(3).value(), "found 3"); }

}  // namespace
}  // namespace turgor

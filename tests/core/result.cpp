#include "turgor/core/result.hpp"

#include <memory>

#include <gtest/gtest.h>

namespace turgor {
namespace {

Result<int> half(int n) {
  if (n % 2 != 0) return Error{"expected an even number, found " + std::to_string(n)};
  return n / 2;
}

// A result holds either a value or an error message.
TEST(Result, HoldsValueOrError) {
  EXPECT_TRUE(half(4));
  EXPECT_EQ(*half(4), 2);
  EXPECT_FALSE(half(3));
  EXPECT_EQ(half(3).error().message, "expected an even number, found 3");
}

// A value that cannot be copied moves out of a result.
TEST(Result, MovesNonCopyableValues) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  const std::unique_ptr<int> taken = *std::move(result);
  EXPECT_EQ(*taken, 5);
}

// value() of an error aborts with the error message.
TEST(Result, ValueOfErrorAborts) { EXPECT_DEATH(half(3).value(), "found 3"); }

}  // namespace
}  // namespace turgor

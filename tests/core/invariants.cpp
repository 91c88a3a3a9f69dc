#include "turgor/core/invariants.hpp"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace turgor {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Invariants, IndexIsInRange) {
  EXPECT_TRUE(is_index(0, 1));
  EXPECT_FALSE(is_index(1, 1));
  EXPECT_FALSE(is_index(-1, 1));
  EXPECT_FALSE(is_index(0, 0));
  EXPECT_TRUE(is_index(std::uint32_t(4), 5));
  EXPECT_TRUE(are_indices(Int3{0, 1, 2}, 3));
  EXPECT_FALSE(are_indices(Int3{0, 1, 3}, 3));
  EXPECT_TRUE(all_indices(std::vector<Int3>{{0, 1, 2}, {2, 1, 0}}, 3));
  EXPECT_FALSE(all_indices(std::vector<int>{0, -1}, 3));
  EXPECT_TRUE(all_indices(std::vector<int>{}, 0));
}

TEST(Invariants, CsrOffsetsAscendToItemCount) {
  EXPECT_TRUE(is_csr(std::vector<int>{0, 2, 2, 5}, 5));
  EXPECT_FALSE(is_csr(std::vector<int>{0, 3, 2, 5}, 5)) << "descends";
  EXPECT_FALSE(is_csr(std::vector<int>{1, 2, 5}, 5)) << "does not begin at 0";
  EXPECT_FALSE(is_csr(std::vector<int>{0, 2, 4}, 5)) << "ends before the last item";
  EXPECT_TRUE(is_csr(std::vector<int>{}, 0));
  EXPECT_FALSE(is_csr(std::vector<int>{}, 1));
}

TEST(Invariants, PermutationHasEveryIndexOnce) {
  EXPECT_TRUE(is_permutation(std::vector<int>{2, 0, 1}, 3));
  EXPECT_FALSE(is_permutation(std::vector<int>{2, 0, 2}, 3)) << "2 occurs twice";
  EXPECT_FALSE(is_permutation(std::vector<int>{3, 0, 1}, 3)) << "3 is out of range";
  EXPECT_FALSE(is_permutation(std::vector<int>{1, 0}, 3)) << "2 is missing";
}

TEST(Invariants, SortedListAscends) {
  EXPECT_TRUE(is_ascending(std::vector<int>{1, 1, 2}));
  EXPECT_FALSE(is_ascending(std::vector<int>{1, 2, 1}));
  EXPECT_TRUE(is_sorted_unique(std::vector<int>{1, 2, 4}));
  EXPECT_FALSE(is_sorted_unique(std::vector<int>{1, 1, 2}));
  using Pair = std::pair<int, int>;
  EXPECT_TRUE(is_sorted_unique(std::vector<Pair>{{0, 5}, {1, 4}}, &Pair::first));
  EXPECT_FALSE(is_ascending(std::vector<Pair>{{0, 5}, {1, 4}}, &Pair::second));
}

TEST(Invariants, ValuesAreFinite) {
  EXPECT_TRUE(all_finite(std::vector<double>{1, 2}));
  EXPECT_FALSE(all_finite(std::vector<double>{1, kNan}));
  EXPECT_TRUE(all_finite(std::vector<Vec3d>{{1, 2, 3}}));
  EXPECT_FALSE(all_finite(std::vector<Vec3d>{{1, kNan, 3}}));
}

TEST(Invariants, WeightsSumToOne) {
  EXPECT_TRUE(sums_to_one(std::vector<double>{0.25, 0.75}));
  EXPECT_FALSE(sums_to_one(std::vector<double>{0.25, 0.7}));
  EXPECT_FALSE(sums_to_one(std::vector<double>{kNan}));
  EXPECT_TRUE(sums_to_one(Vec3d{0.5, 0.25, 0.25}));
}

TEST(Invariants, UnitVectorHasLengthOne) {
  EXPECT_TRUE(is_unit(Vec3d{0, 0.6, 0.8}));
  EXPECT_FALSE(is_unit(Vec3d{0, 0, 1.1}));
  EXPECT_FALSE(is_unit(Vec3d{}));
}

TEST(Invariants, StepLengthIsPositiveAndFinite) {
  EXPECT_TRUE(is_step_length(0.01));
  EXPECT_FALSE(is_step_length(0));
  EXPECT_FALSE(is_step_length(-0.01));
  EXPECT_FALSE(is_step_length(std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(is_step_length(kNan));
}

}  // namespace
}  // namespace turgor

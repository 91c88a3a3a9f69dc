#include "turgor/geometry/dilate.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace turgor {
namespace {

using Mask = std::vector<std::uint8_t>;

/// Reference: visits every cell of the box around every cell.
Mask brute_force(const Mask& mask, Int3 size, int reach) {
  const auto index = [&](int i, int j, int k) { return std::size_t((k * size.y + j) * size.x + i); };
  Mask out(mask.size());
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        for (int c = std::max(0, k - reach); c <= std::min(size.z - 1, k + reach); c++)
          for (int b = std::max(0, j - reach); b <= std::min(size.y - 1, j + reach); b++)
            for (int a = std::max(0, i - reach); a <= std::min(size.x - 1, i + reach); a++)
              out[index(i, j, k)] |= mask[index(a, b, c)];
  return out;
}

// Dilation marks the cells within a box around every marked cell.
TEST(Dilate, MatchesBruteForce) {
  std::mt19937 random(3);
  for (const Int3 size : {Int3{13, 7, 5}, Int3{1, 9, 2}, Int3{6, 1, 1}})
    for (const int reach : {0, 1, 3, 8}) {
      Mask mask(std::size_t(size.x * size.y * size.z));
      for (auto& cell : mask) cell = random() % 25 == 0;
      const Mask expected = brute_force(mask, size, reach);
      for (const int threads : {1, 3}) {
        Mask grown = mask;
        dilate(Exec(threads), grown, size, reach);
        EXPECT_EQ(grown, expected);
      }
    }
}

}  // namespace
}  // namespace turgor

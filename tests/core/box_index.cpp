#include "turgor/core/box_index.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// An index along the axes gives back its sample, in small boxes and in those whose indices need more than 32
// bits.
TEST(BoxIndex, IsInverseOfIndex) {
  for (const Int3 size : {Int3{1, 1, 1}, Int3{3, 5, 7}, Int3{512, 512, 275}, Int3{3000, 2000, 1500}}) {
    const std::size_t x = std::size_t(size.x), y = std::size_t(size.y), count = x * y * std::size_t(size.z);
    for (const std::size_t n : {std::size_t(0), count / 7, count / 2, count - 1 - count / 11, count - 1}) {
      const Int3 p = box_index(size, n);
      EXPECT_EQ((std::size_t(p.z) * y + std::size_t(p.y)) * x + std::size_t(p.x), n);
      EXPECT_TRUE(p.x >= 0 && p.x < size.x && p.y >= 0 && p.y < size.y && p.z >= 0 && p.z < size.z);
    }
  }
}

}  // namespace
}  // namespace turgor

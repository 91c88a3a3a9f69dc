#include "turgor/geometry/row_components.hpp"

#include <random>

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// Numbers the parts by visiting neighbours, one cell after the other.
std::vector<int> flooded(const std::vector<std::uint8_t>& mask, Int3 size) {
  std::vector<int> part(mask.size(), -1);
  const auto index = [&](Int3 p) { return std::size_t((p.z * size.y + p.y) * size.x + p.x); };
  int count = 0;
  for (std::size_t n = 0; n < mask.size(); n++) {
    if (!mask[n] || part[n] >= 0) continue;
    std::vector<Int3> stack{{int(n) % size.x, int(n) / size.x % size.y, int(n) / (size.x * size.y)}};
    part[n] = count;
    while (!stack.empty()) {
      const Int3 p = stack.back();
      stack.pop_back();
      for (int axis = 0; axis < 3; axis++)
        for (const int way : {-1, 1}) {
          Int3 q = p;
          q[axis] += way;
          if (q[axis] < 0 || q[axis] >= size[axis] || !mask[index(q)] || part[index(q)] >= 0) continue;
          part[index(q)] = count;
          stack.push_back(q);
        }
    }
    count++;
  }
  return part;
}

TEST(RowComponents, AreThoseThatAFloodFinds) {
  std::mt19937 random(7);
  const Int3 size{23, 11, 9};
  for (const int percent : {0, 5, 30, 45, 60, 100}) {
    std::vector<std::uint8_t> mask(23 * 11 * 9);
    for (auto& cell : mask) cell = int(random() % 100) < percent;
    const std::vector<int> expected = flooded(mask, size);
    std::vector<int> found(mask.size(), -1);
    const RowComponents parts = row_components(mask, size);
    std::vector<std::size_t> sizes(parts.sizes.size());
    for (const CellRun& run : parts.runs)
      for (int i = run.begin; i < run.end; i++) {
        found[std::size_t((run.k * size.y + run.j) * size.x + i)] = run.part;
        sizes[std::size_t(run.part)]++;
      }
    EXPECT_EQ(found, expected) << percent << " %";
    EXPECT_EQ(parts.sizes, sizes) << percent << " %";
    EXPECT_EQ(parts.largest() < 0, percent == 0);
  }
}

}  // namespace
}  // namespace turgor

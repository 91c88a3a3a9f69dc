#include "turgor/geometry/row_components.hpp"

#include <random>

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// Reference: numbers the components by flood fill.
std::vector<int> flooded(const std::vector<std::uint8_t>& mask, Int3 size) {
  std::vector<int> component(mask.size(), -1);
  const auto index = [&](Int3 p) { return std::size_t((p.z * size.y + p.y) * size.x + p.x); };
  int count = 0;
  for (std::size_t n = 0; n < mask.size(); n++) {
    if (!mask[n] || component[n] >= 0) continue;
    std::vector<Int3> stack{{int(n) % size.x, int(n) / size.x % size.y, int(n) / (size.x * size.y)}};
    component[n] = count;
    while (!stack.empty()) {
      const Int3 p = stack.back();
      stack.pop_back();
      for (int axis = 0; axis < 3; axis++)
        for (const int step : {-1, 1}) {
          Int3 q = p;
          q[axis] += step;
          if (q[axis] < 0 || q[axis] >= size[axis] || !mask[index(q)] || component[index(q)] >= 0) continue;
          component[index(q)] = count;
          stack.push_back(q);
        }
    }
    count++;
  }
  return component;
}

// The components equal those of a flood fill.
TEST(RowComponents, MatchFloodFill) {
  std::mt19937 random(7);
  const Int3 size{23, 11, 9};
  for (const int percent : {0, 5, 30, 45, 60, 100}) {
    std::vector<std::uint8_t> mask(23 * 11 * 9);
    for (auto& cell : mask) cell = int(random() % 100) < percent;
    const std::vector<int> expected = flooded(mask, size);
    std::vector<int> found(mask.size(), -1);
    const RowComponents components = row_components(mask, size);
    std::vector<std::size_t> sizes(components.sizes.size());
    for (const CellRun& run : components.runs)
      for (int i = run.begin; i < run.end; i++) {
        found[std::size_t((run.k * size.y + run.j) * size.x + i)] = run.component;
        sizes[std::size_t(run.component)]++;
      }
    EXPECT_EQ(found, expected) << percent << " %";
    EXPECT_EQ(components.sizes, sizes) << percent << " %";
    EXPECT_EQ(components.largest() < 0, percent == 0);
  }
}

}  // namespace
}  // namespace turgor

#include "turgor/geometry/weld.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Triangles use the first of coincident vertices; degenerate triangles are removed.
TEST(Weld, JoinsCoincidentVerticesDropsDegenerate) {
  const TriMesh strip{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {-0.0f, 0, 0}},
                      {{0, 1, 2}, {3, 4, 5}, {0, 4, 1}, {6, 4, 3}}};
  const TriMesh found = welded(strip);
  EXPECT_EQ(found.vertices, strip.vertices);
  EXPECT_EQ(found.triangles, (std::vector<Int3>{{0, 1, 2}, {2, 1, 5}, {0, 1, 2}}));
}

}  // namespace
}  // namespace turgor

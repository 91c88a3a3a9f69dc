#include "turgor/geometry/weld.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

TEST(Weld, triangles_take_the_first_vertex_of_a_place_and_flat_ones_go) {
  const TriMesh strip{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {-0.0f, 0, 0}},
                      {{0, 1, 2}, {3, 4, 5}, {0, 4, 1}, {6, 4, 3}}};
  const TriMesh found = welded(strip);
  EXPECT_EQ(found.vertices, strip.vertices);
  EXPECT_EQ(found.triangles, (std::vector<Int3>{{0, 1, 2}, {2, 1, 5}, {0, 1, 2}}));
}

}  // namespace
}  // namespace turgor

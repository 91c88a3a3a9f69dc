#include "turgor/geometry/manifold.hpp"

#include <gtest/gtest.h>

#include "tests/geometry/mesh_checks.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor {
namespace {

/// The tetrahedra of a 2×2×2 block whose hexahedra are chosen, six each.
SolidMesh chosen(std::initializer_list<int> hexahedra) {
  const SolidMesh whole = tetrahedralize(hex_block({2, 2, 2}, {2, 2, 2}));
  std::vector<std::uint8_t> keep(element_count(whole));
  for (const int h : hexahedra)
    for (int t = 0; t < 6; t++) keep[std::size_t(h * 6 + t)] = 1;
  return kept_elements(whole, keep);
}

// The kept elements come with their own vertices and regions.
TEST(Manifold, KeptElementsKeepVerticesAndRegions) {
  SolidMesh block = hex_block({2, 1, 1}, {2, 1, 1});
  block.regions = {4, 7};
  const std::uint8_t keep[] = {0, 1};
  const SolidMesh half = kept_elements(block, keep);
  EXPECT_EQ(half.vertices.size(), 8u);
  EXPECT_EQ(half.regions, std::vector<int>{7});
  EXPECT_NEAR(volume(half), 1, 1e-15);
}

// A mesh that is a manifold is not changed.
TEST(Manifold, ManifoldMeshIsUnchanged) {
  const SolidMesh whole = chosen({0, 1, 2, 3, 4, 5, 6, 7}), made = make_manifold(whole);
  EXPECT_EQ(made.elements, whole.elements);
  EXPECT_EQ(made.vertices.size(), whole.vertices.size());
}

// Two cubes that share only a corner get a vertex each.
TEST(Manifold, SharedCornerIsDuplicated) {
  const SolidMesh touching = chosen({0, 7}), made = make_manifold(touching);
  EXPECT_EQ(touching.vertices.size(), 15u);
  EXPECT_EQ(made.vertices.size(), 16u);
  EXPECT_NEAR(volume(made), 2, 1e-14);
  test::expect_sound(made);
}

// Two cubes share only an edge: one of them loses the elements at that edge.
TEST(Manifold, SharedEdgeLosesElements) {
  const SolidMesh made = make_manifold(chosen({0, 3}));
  EXPECT_GT(volume(made), 1);
  EXPECT_LT(volume(made), 2);
  test::expect_sound(made);
}

// A vertex whose elements have two openings loses elements.
TEST(Manifold, VertexWithTwoOpeningsLosesElements) {
  // All cubes around the center except two opposite ones: one component with two openings.
  const SolidMesh pierced = chosen({1, 2, 3, 4, 5, 6}), made = make_manifold(pierced);
  EXPECT_LT(volume(made), volume(pierced));
  EXPECT_GT(volume(made), 0);
  test::expect_sound(made);
}

}  // namespace
}  // namespace turgor

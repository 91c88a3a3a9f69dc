#include "turgor/geometry/solid_mesh.hpp"

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"

namespace turgor {
namespace {

double enclosed_volume(const SolidMesh& mesh, const SolidSurface& outer) {
  double sum = 0;
  for (const auto [a, b, c] : outer.triangles)
    sum += orientation({}, mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)],
                       mesh.vertices[std::size_t(c)]) /
           6;
  return sum;
}

// The surface of a block encloses the volume of its elements.
TEST(SolidMesh, SurfaceEnclosesVolume) {
  const SolidMesh block = hex_block({0.3, 0.2, 0.1}, {3, 4, 5});
  const SolidMesh tets = tetrahedralize(block);
  EXPECT_NEAR(volume(block), 0.006, 1e-15);
  EXPECT_NEAR(volume(tets), 0.006, 1e-15);
  EXPECT_NEAR(enclosed_volume(block, surface(block)), 0.006, 1e-15);
  EXPECT_NEAR(enclosed_volume(tets, surface(tets)), 0.006, 1e-15);
  EXPECT_EQ(surface(block).triangles.size(), 2u * 2 * (3 * 4 + 4 * 5 + 5 * 3));
}

// Every tetrahedron of a block has the same positive volume.
TEST(SolidMesh, TetrahedraArePositivelyOriented) {
  const SolidMesh tets = tetrahedralize(hex_block({1, 1, 1}, {2, 2, 2}));
  for (std::size_t e = 0; e < element_count(tets); e++) EXPECT_NEAR(volume(tets, e), 1.0 / 48, 1e-15) << e;
}

// The volume of a skewed hexahedron is that of its map.
TEST(SolidMesh, SkewedHexahedronVolume) {
  SolidMesh block = hex_block({1, 1, 1}, {1, 1, 1});
  for (Vec3d& x : block.vertices) x = {x.x + 0.5 * x.z, x.y + 0.2 * x.x, 2 * x.z};
  EXPECT_NEAR(volume(block, 0), 2.0, 1e-14);
}

// Elements that share only an edge belong to different components.
TEST(SolidMesh, SharedEdgeDoesNotConnect) {
  SolidMesh two = hex_block({2, 2, 1}, {2, 2, 1});
  // Keep the elements at (0, 0) and (1, 1), which share an edge, and append one more beside the first.
  std::vector<int> kept;
  for (const std::size_t e : {0u, 3u, 1u})
    for (const int v : element(two, e)) kept.push_back(v);
  two.elements = {kept.begin(), kept.begin() + 16};
  EXPECT_EQ(connected_components(two), (std::vector<int>{0, 1}));
  two.elements = kept;
  EXPECT_EQ(connected_components(two), (std::vector<int>{0, 0, 0}));
}

}  // namespace
}  // namespace turgor

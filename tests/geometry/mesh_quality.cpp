#include "turgor/geometry/mesh_quality.hpp"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"

namespace turgor {
namespace {

// All dihedral angles of a regular tetrahedron are 70.53°.
TEST(MeshQuality, RegularTetrahedronAngles) {
  for (const double angle : dihedral_angles({{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}}))
    EXPECT_NEAR(angle, 70.528779365509, 1e-10);
}

// The corner tetrahedron of a cube has three right angles and three of 54.74°.
TEST(MeshQuality, CubeCornerAngles) {
  const auto angles = dihedral_angles({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  for (const std::size_t edge : {0u, 1u, 2u}) EXPECT_NEAR(angles[edge], 90, 1e-10);
  for (const std::size_t edge : {3u, 4u, 5u}) EXPECT_NEAR(angles[edge], 54.735610317245, 1e-10);
}

// A block of Kuhn tetrahedra has dihedral angles of 45° to 90° and the expected edges and volumes.
TEST(MeshQuality, KuhnCubeAngles) {
  const MeshQuality quality = measure_quality(tetrahedralize(hex_block({0.1, 0.1, 0.1}, {2, 2, 2})));
  EXPECT_NEAR(quality.min_dihedral, 45, 1e-9);
  EXPECT_NEAR(quality.max_dihedral, 90, 1e-9);
  EXPECT_NEAR(quality.shortest_edge, 0.05, 1e-12);
  EXPECT_NEAR(quality.longest_edge, 0.05 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(quality.volume, 1e-3, 1e-15);
  EXPECT_NEAR(quality.smallest_volume, 1e-3 / 48, 1e-15);
  const auto& histogram = quality.dihedral_histogram;
  EXPECT_EQ(std::accumulate(histogram.begin(), histogram.end(), std::size_t(0)), 6u * 48);
}

// An inverted element has a negative volume.
TEST(MeshQuality, InvertedElementHasNegativeVolume) {
  SolidMesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .elements = {0, 2, 1, 3}};
  EXPECT_NEAR(measure_quality(mesh).smallest_volume, -1.0 / 6, 1e-15);
  EXPECT_EQ(measure_quality({}).max_dihedral, 0);
}

}  // namespace
}  // namespace turgor

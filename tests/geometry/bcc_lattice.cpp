#include "turgor/geometry/bcc_lattice.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {
namespace {

const BccLattice kLattice{{0.1, -0.2, 0.3}, 0.5, {4, 5, 6}};

// Every point id maps to a point with the same id.
TEST(BccLattice, PointIdsRoundTrip) {
  for (std::int64_t id = 0; id < point_count(kLattice); id++)
    ASSERT_EQ(point_id(kLattice, point_of(kLattice, id)), id);
}

// The twelve tetrahedra per cube have equal volumes that sum to the volume of the cube.
TEST(BccLattice, TwelveTetrahedraFillCube) {
  double sum = 0;
  for (int axis = 0; axis < 3; axis++)
    for (const auto& tet : tetrahedra_around({1, 2, 3}, axis)) {
      const auto x = [&](std::size_t c) { return place_of(kLattice, tet[c]); };
      const double volume = orientation(x(0), x(1), x(2), x(3)) / 6;
      EXPECT_NEAR(volume, 0.125 / 12, 1e-15);
      sum += volume;
    }
  EXPECT_NEAR(sum, 0.125, 1e-15);
}

// An inner point has six neighbors at the cell size and eight at half the cube diagonal.
TEST(BccLattice, PointsHaveFourteenNeighbors) {
  std::vector<int> far(std::size_t(point_count(kLattice))), near(far.size());
  for (std::int64_t id = 0; id < point_count(kLattice); id++) {
    const BccPoint p = point_of(kLattice, id);
    const BccNeighbors neighbors = higher_neighbors(p);
    for (int i = 0; i < neighbors.count; i++) {
      const BccPoint q = neighbors.point[std::size_t(i)];
      if (!contains(kLattice, q)) continue;
      ASSERT_GT(point_id(kLattice, q), id);
      auto& list = p.grid == q.grid ? far : near;
      EXPECT_NEAR(norm(place_of(kLattice, p) - place_of(kLattice, q)),
                  0.5 * (p.grid == q.grid ? 1 : std::sqrt(0.75)), 1e-15);
      list[std::size_t(id)]++, list[std::size_t(point_id(kLattice, q))]++;
    }
  }
  for (const int grid : {0, 1}) {
    const auto middle = std::size_t(point_id(kLattice, {{2, 2, 2}, grid}));
    EXPECT_EQ(far[middle], 6);
    EXPECT_EQ(near[middle], 8);
  }
}

}  // namespace
}  // namespace turgor

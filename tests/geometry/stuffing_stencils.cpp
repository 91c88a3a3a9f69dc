#include "turgor/geometry/stuffing_stencils.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor::stuffing {
namespace {

const BccLattice kLattice{{}, 1, {4, 4, 4}};

/// A tetrahedron and a linear function on it, zero at the corners on the surface: its cut is a plane.
struct Sliced {
  LatticeTet tet;
  std::array<double, 4> value;

  double value_at(std::int64_t id) const {
    for (std::size_t c = 0; c < 4; c++)
      if (tet.id[c] == id) return value[c];
    return NAN;
  }
  Vec3d position(const Corner& corner) const {
    const Vec3d a = place_of(kLattice, point_of(kLattice, corner.point));
    if (corner.to < 0) return a;
    const Vec3d b = place_of(kLattice, point_of(kLattice, corner.to));
    const double f = value_at(corner.point), g = value_at(corner.to);
    return a + (b - a) * (f / (f - g));
  }
  /// Volume of the inside; checks that every tetrahedron has positive orientation.
  double inner_volume(std::size_t* count = nullptr) const {
    std::vector<Corner> corners;
    append_inside(tet, corners);
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); i += 4) {
      const double volume = orientation(position(corners[i]), position(corners[i + 1]),
                                        position(corners[i + 2]), position(corners[i + 3])) /
                            6;
      EXPECT_GT(volume, 0);
      sum += volume;
    }
    if (count) *count = corners.size() / 4;
    return sum;
  }
};

Sliced sliced(const std::array<BccPoint, 4>& points, int pattern, std::mt19937& random) {
  std::uniform_real_distribution<double> size(0.1, 1);
  Sliced result{};
  for (std::size_t c = 0; c < 4; c++, pattern /= 3) {
    const int side = pattern % 3;
    result.tet.point[c] = points[c];
    result.tet.id[c] = point_id(kLattice, points[c]);
    result.tet.side[c] = Side(side);
    result.value[c] = (side - 1) * size(random);
  }
  return result;
}

Sliced turned_inside_out(Sliced s) {
  for (std::size_t c = 0; c < 4; c++) {
    s.tet.side[c] = Side(2 - int(s.tet.side[c]));
    s.value[c] = -s.value[c];
  }
  return s;
}

// The inner and the outer volume of every sliced tetrahedron sum to its volume.
TEST(StuffingStencils, InsideAndOutsideFillTetrahedron) {
  std::mt19937 random(5);
  for (int axis = 0; axis < 3; axis++)
    for (const auto& points : tetrahedra_around({1, 1, 1}, axis))
      for (int pattern = 0; pattern < 81; pattern++) {
        const Sliced inner = sliced(points, pattern, random);
        if (pattern == 40) continue;  // all four corners on the surface: neither inside nor outside
        EXPECT_NEAR(inner.inner_volume() + turned_inside_out(inner).inner_volume(), 1.0 / 12, 1e-15)
            << pattern;
      }
}

// One inside corner gives one tetrahedron; two or three give three.
TEST(StuffingStencils, TetrahedraPerSignPattern) {
  std::mt19937 random(6);
  const auto points = tetrahedra_around({1, 1, 1}, 0)[0];
  // Patterns in base 3, from the first corner on: 0 inside, 1 on the surface, 2 outside.
  const auto tetrahedra_of = [&](int a, int b, int c, int d) {
    std::size_t count = 0;
    sliced(points, a + 3 * b + 9 * c + 27 * d, random).inner_volume(&count);
    return count;
  };
  EXPECT_EQ(tetrahedra_of(0, 2, 2, 2), 1u);
  EXPECT_EQ(tetrahedra_of(0, 0, 2, 2), 3u);
  EXPECT_EQ(tetrahedra_of(0, 2, 2, 0), 3u);
  EXPECT_EQ(tetrahedra_of(0, 0, 0, 2), 3u);
  EXPECT_EQ(tetrahedra_of(0, 0, 1, 2), 2u);
  EXPECT_EQ(tetrahedra_of(0, 1, 1, 1), 1u);
  EXPECT_EQ(tetrahedra_of(1, 1, 1, 2), 0u);
}

}  // namespace
}  // namespace turgor::stuffing

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
  Vec3d place(const Corner& corner) const {
    const Vec3d a = place_of(kLattice, point_of(kLattice, corner.point));
    if (corner.to < 0) return a;
    const Vec3d b = place_of(kLattice, point_of(kLattice, corner.to));
    const double f = value_at(corner.point), g = value_at(corner.to);
    return a + (b - a) * (f / (f - g));
  }
  /// Volume of the inner part; every tetrahedron of it is the right way round.
  double inner_volume(std::size_t* count = nullptr) const {
    std::vector<Corner> corners;
    append_inner_part(tet, corners);
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); i += 4) {
      const double volume = orientation(place(corners[i]), place(corners[i + 1]), place(corners[i + 2]),
                                        place(corners[i + 3])) /
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

TEST(StuffingStencils, the_inner_and_the_outer_part_of_every_tetrahedron_make_the_whole) {
  std::mt19937 random(5);
  for (int axis = 0; axis < 3; axis++)
    for (const auto& points : tetrahedra_around({1, 1, 1}, axis))
      for (int pattern = 0; pattern < 81; pattern++) {
        const Sliced inner = sliced(points, pattern, random);
        if (pattern == 40) continue;  // all four corners on the surface: neither in nor out
        EXPECT_NEAR(inner.inner_volume() + turned_inside_out(inner).inner_volume(), 1.0 / 12, 1e-15)
            << pattern;
      }
}

TEST(StuffingStencils, one_inside_corner_leaves_one_tetrahedron_two_or_three_leave_three) {
  std::mt19937 random(6);
  const auto points = tetrahedra_around({1, 1, 1}, 0)[0];
  // Patterns in base 3, from the first corner on: 0 inside, 1 on the surface, 2 outside.
  const auto parts = [&](int a, int b, int c, int d) {
    std::size_t count = 0;
    sliced(points, a + 3 * b + 9 * c + 27 * d, random).inner_volume(&count);
    return count;
  };
  EXPECT_EQ(parts(0, 2, 2, 2), 1u);
  EXPECT_EQ(parts(0, 0, 2, 2), 3u);
  EXPECT_EQ(parts(0, 2, 2, 0), 3u);
  EXPECT_EQ(parts(0, 0, 0, 2), 3u);
  EXPECT_EQ(parts(0, 0, 1, 2), 2u);
  EXPECT_EQ(parts(0, 1, 1, 1), 1u);
  EXPECT_EQ(parts(1, 1, 1, 2), 0u);
}

}  // namespace
}  // namespace turgor::stuffing

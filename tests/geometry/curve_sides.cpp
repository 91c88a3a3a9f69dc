#include "turgor/geometry/curve_sides.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "tests/geometry/shapes.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/organ_mesh.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor {
namespace {

SolidMesh meshed(const TriMesh& surface, double size, Sides sides, int threads = 2) {
  return mesh_of_surface(Exec(threads), surface, size, {}, sides).value().mesh;
}

double thinnest(const SolidMesh& mesh) {
  const SolidMesh flat = without_middles(mesh);
  double least = 1;
  for (std::size_t e = 0; e < element_count(mesh); e++)
    least = std::min(least, least_map_volume(mesh, e) / volume(flat, e));
  return least;
}

/// Largest deviation of the facets' corners and midpoints from a sphere [m].
struct Deviation {
  double corner = 0, middle = 0;
};
Deviation deviation_from_sphere(const SolidMesh& mesh, Vec3d center, double radius) {
  Deviation deviation;
  for (const auto [a, b, c] : surface(mesh).triangles) {
    const auto from = [&](Vec3d x) { return std::abs(norm(x - center) - radius); };
    const Vec3d x[] = {mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)],
                       mesh.vertices[std::size_t(c)]};
    for (const Vec3d corner : x) deviation.corner = std::max(deviation.corner, from(corner));
    deviation.middle = std::max(deviation.middle, from((x[0] + x[1] + x[2]) / 3));
  }
  return deviation;
}

// Curved sides put every surface node on the sphere; flat sides bulge beyond it to keep the volume.
TEST(CurveSides, BallNodesLieOnSphere) {
  const Vec3d center{0.1, -0.3, 0.02};
  const TriMesh ball = test::sphere_surface(center, 0.05, 5);
  for (const double size : {0.03, 0.02, 0.015}) {
    const Deviation curved = deviation_from_sphere(meshed(ball, size, Sides::kCurved), center, 0.05);
    const Deviation flat = deviation_from_sphere(meshed(ball, size, Sides::kFlat), center, 0.05);
    EXPECT_LT(curved.corner, 2e-5) << "deviation of the input triangles";
    EXPECT_GT(flat.corner, 10 * curved.corner);
    // The sagitta of a facet whose corners are half of the longest edge, 5/4 of the size, apart.
    EXPECT_LT(curved.middle, 1.25 * size * 1.25 * size / 4 / (6 * 0.05) * 1.3);
  }
}

// A ball keeps the volume of its surface, in quadratic elements and in their linear subdivision.
TEST(CurveSides, BallKeepsVolume) {
  const TriMesh ball = test::sphere_surface({0, 0, 0}, 0.04, 5);
  const SolidMesh mesh = meshed(ball, 0.02, Sides::kCurved);
  EXPECT_NEAR(volume(mesh), 4 * std::numbers::pi / 3 * 6.4e-5, 0.004 * volume(mesh));
  EXPECT_NEAR(volume(linear_subdivision(mesh)), volume(mesh), 0.03 * volume(mesh))
      << "linear elements replace curves by chords";
}

// At sharp edges and notches no element falls below kLeastOfFlat, and the shape keeps its volume.
TEST(CurveSides, EdgesAndNotches_BoundThinness) {
  const std::pair<TriMesh, double> shapes[] = {{test::notched_surface(), 4 - std::tan(std::numbers::pi / 6)},
                                               {test::box_surface({1, 0.6, 0.3}), 0.18}};
  for (const auto& [shape, exact] : shapes)
    for (const double size : {0.31, 0.17}) {
      const SolidMesh mesh = meshed(shape, size, Sides::kCurved);
      EXPECT_GE(thinnest(mesh), kLeastOfFlat);
      EXPECT_NEAR(volume(mesh), exact, 0.01 * exact) << size;
    }
}

// The least map volume equals the volume of a flat element and is negative if the map folds.
TEST(CurveSides, LeastMapVolume_DetectsFolds) {
  SolidMesh mesh = with_middles(SolidMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 4, {0, 1, 2, 3}, {}});
  EXPECT_NEAR(least_map_volume(mesh, 0), 1.0 / 6, 1e-15);
  EXPECT_NEAR(volume(mesh), 1.0 / 6, 1e-15);
  mesh.vertices[std::size_t(element(mesh, 0)[std::size_t(node_between(0, 1))])] = {0.9, 0, 0};
  EXPECT_LT(least_map_volume(mesh, 0), 0);
}

// The volume of a quadratic map is exact up to rounding.
TEST(CurveSides, QuadraticMapVolumeIsExact) {
  // x' = x, y' = y, z' = z + y² + 2 x y + x² is quadratic and keeps every volume.
  SolidMesh mesh = with_middles(tetrahedralize(hex_block({1, 2, 1}, {1, 1, 1})));
  for (Vec3d& x : mesh.vertices) x.z += x.y * x.y + 2 * x.x * x.y + x.x * x.x;
  EXPECT_NEAR(volume(mesh), 2, 1e-14);
}

// One and eight threads give the same bits.
TEST(CurveSides, EqualBitsOnAnyThreads) {
  const TriMesh ball = test::sphere_surface({0, 0, 0}, 0.04, 3);
  const SolidMesh one = meshed(ball, 0.017, Sides::kCurved, 1),
                  eight = meshed(ball, 0.017, Sides::kCurved, 8);
  ASSERT_EQ(one.vertices.size(), eight.vertices.size());
  for (std::size_t v = 0; v < one.vertices.size(); v++) EXPECT_EQ(one.vertices[v], eight.vertices[v]);
}

}  // namespace
}  // namespace turgor

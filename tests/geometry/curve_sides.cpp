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

SolidMesh filled(const TriMesh& surface, double size, Sides sides, int threads = 2) {
  return mesh_of_surface(Exec(threads), surface, size, {}, sides).value().mesh;
}

double thinnest(const SolidMesh& mesh) {
  const SolidMesh flat = without_middles(mesh);
  double least = 1;
  for (std::size_t e = 0; e < element_count(mesh); e++)
    least = std::min(least, least_map_volume(mesh, e) / volume(flat, e));
  return least;
}

/// How far the facets' corners and middles are from a ball's surface at most [m].
struct Off {
  double corner = 0, middle = 0;
};
Off off_the_ball(const SolidMesh& mesh, Vec3d center, double radius) {
  Off off;
  for (const auto [a, b, c] : surface(mesh).triangles) {
    const auto from = [&](Vec3d x) { return std::abs(norm(x - center) - radius); };
    const Vec3d x[] = {mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)],
                       mesh.vertices[std::size_t(c)]};
    for (const Vec3d corner : x) off.corner = std::max(off.corner, from(corner));
    off.middle = std::max(off.middle, from((x[0] + x[1] + x[2]) / 3));
  }
  return off;
}

TEST(CurveSides, every_node_of_a_ball_s_outline_is_on_it_where_flat_sides_bulge_to_keep_the_volume) {
  const Vec3d center{0.1, -0.3, 0.02};
  const TriMesh ball = test::sphere_surface(center, 0.05, 5);
  for (const double size : {0.03, 0.02, 0.015}) {
    const Off curved = off_the_ball(filled(ball, size, Sides::kCurved), center, 0.05);
    const Off flat = off_the_ball(filled(ball, size, Sides::kFlat), center, 0.05);
    EXPECT_LT(curved.corner, 2e-5) << "what the triangles of the given surface are off";
    EXPECT_GT(flat.corner, 10 * curved.corner);
    // The sagitta of a facet whose corners are half of the longest edge, 5/4 of the size, apart.
    EXPECT_LT(curved.middle, 1.25 * size * 1.25 * size / 4 / (6 * 0.05) * 1.3);
  }
}

TEST(CurveSides, a_ball_s_volume_is_that_of_its_surface_and_of_the_map_s_elements) {
  const TriMesh ball = test::sphere_surface({0, 0, 0}, 0.04, 5);
  const SolidMesh mesh = filled(ball, 0.02, Sides::kCurved);
  EXPECT_NEAR(volume(mesh), 4 * std::numbers::pi / 3 * 6.4e-5, 0.004 * volume(mesh));
  EXPECT_NEAR(volume(linear_parts(mesh)), volume(mesh), 0.03 * volume(mesh)) << "they see curves as chords";
}

TEST(CurveSides, no_element_becomes_thinner_than_told_at_edges_and_notches_and_the_volume_is_the_shape_s) {
  const std::pair<TriMesh, double> shapes[] = {{test::notched_surface(), 4 - std::tan(std::numbers::pi / 6)},
                                               {test::box_surface({1, 0.6, 0.3}), 0.18}};
  for (const auto& [shape, wanted] : shapes)
    for (const double size : {0.31, 0.17}) {
      const SolidMesh mesh = filled(shape, size, Sides::kCurved);
      EXPECT_GE(thinnest(mesh), kLeastOfFlat);
      EXPECT_NEAR(volume(mesh), wanted, 0.01 * wanted) << size;
    }
}

TEST(CurveSides, the_least_of_a_map_is_its_volume_if_flat_and_below_zero_if_it_folds) {
  SolidMesh mesh = with_middles(SolidMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 4, {0, 1, 2, 3}, {}});
  EXPECT_NEAR(least_map_volume(mesh, 0), 1.0 / 6, 1e-15);
  EXPECT_NEAR(volume(mesh), 1.0 / 6, 1e-15);
  mesh.vertices[std::size_t(element(mesh, 0)[std::size_t(node_between(0, 1))])] = {0.9, 0, 0};
  EXPECT_LT(least_map_volume(mesh, 0), 0);
}

TEST(CurveSides, a_quadratic_map_s_volume_is_exact) {
  // x' = x, y' = y, z' = z + y² + 2 x y + x² is quadratic and keeps every volume.
  SolidMesh mesh = with_middles(tetrahedralize(hex_block({1, 2, 1}, {1, 1, 1})));
  for (Vec3d& x : mesh.vertices) x.z += x.y * x.y + 2 * x.x * x.y + x.x * x.x;
  EXPECT_NEAR(volume(mesh), 2, 1e-14);
}

TEST(CurveSides, one_and_eight_threads_give_the_same_bits) {
  const TriMesh ball = test::sphere_surface({0, 0, 0}, 0.04, 3);
  const SolidMesh one = filled(ball, 0.017, Sides::kCurved, 1),
                  eight = filled(ball, 0.017, Sides::kCurved, 8);
  ASSERT_EQ(one.vertices.size(), eight.vertices.size());
  for (std::size_t v = 0; v < one.vertices.size(); v++) EXPECT_EQ(one.vertices[v], eight.vertices[v]);
}

}  // namespace
}  // namespace turgor

#include "turgor/models/rhombus/geodesic.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/rhombus/bodies.hpp"

namespace turgor::rhombus {
namespace {

TrianglePoint nearest(const Surface& surface, Vec3d p) {
  return nearest_point(build_triangle_tree(surface.vertices, surface.triangles), p);
}

// On a plane, the geodesic distance is the straight distance for any triangulation.
TEST(RhombusGeodesic, PlaneIsExactOnAnyMesh) {
  for (const double uneven : {0.0, 0.2, 0.35}) {
    const Surface surface = test::slab(0.2, 40, uneven);
    for (const Vec3d p : {Vec3d{0.0012, -0.0034, 0}, Vec3d{0, 0, 0}, Vec3d{0.0025, 0, 0}}) {
      GeodesicField field;
      const TrianglePoint source = nearest(surface, p);
      measure_distances(surface, source, 0.06, field);
      double worst = 0;
      std::size_t inside = 0;
      for (std::size_t v = 0; v < surface.vertices.size(); v++) {
        const double straight = norm(surface.vertices[v] - source.position);
        if (surface.vertices[v].z < -1e-9 || straight > 0.06) continue;
        inside++;
        worst = std::max(worst, std::abs(field.distance[v] - straight));
      }
      EXPECT_GT(inside, 400u);
      EXPECT_LT(worst, 1e-12) << "uneven " << uneven;
    }
  }
}

// On a sphere, the geodesic distance converges to the arc as triangles get smaller.
TEST(RhombusGeodesic, SphereConvergesToArc) {
  const double radius = 0.05;
  double before = 1;
  for (const int times : {3, 4, 5}) {
    const Surface surface = test::sphere(radius, times);
    GeodesicField field;
    const TrianglePoint source = nearest(surface, Vec3d{0.3, 0.5, 0.8} * radius);
    measure_distances(surface, source, 0.08, field);
    double worst = 0;
    for (const int v : field.reached) {
      const double cosine = dot(normalized(surface.vertices[std::size_t(v)]), normalized(source.position));
      const double arc = radius * std::acos(std::clamp(cosine, -1.0, 1.0));
      if (arc < 0.08) worst = std::max(worst, std::abs(field.distance[std::size_t(v)] - arc));
    }
    EXPECT_LT(worst, 0.6 * before);
    EXPECT_LT(worst, 0.08 * surface.mean_edge) << times;
    std::printf("sphere, edges %.2f mm: largest error %.4f mm up to 80 mm away\n", surface.mean_edge * 1e3,
                worst * 1e3);
    before = worst;
  }
}

// The search stops at the radius, and a reused field equals a fresh one.
TEST(RhombusGeodesic, StopsAtRadiusAndResets) {
  const Surface surface = test::slab(0.2, 40, 0.3);
  GeodesicField used, fresh;
  measure_distances(surface, nearest(surface, {0.05, 0.05, 0}), 0.08, used);
  measure_distances(surface, nearest(surface, {-0.01, 0.02, 0}), 0.03, used);
  measure_distances(surface, nearest(surface, {-0.01, 0.02, 0}), 0.03, fresh);
  EXPECT_EQ(used.distance, fresh.distance);
  EXPECT_EQ(used.reached, fresh.reached);
  for (const double d : used.distance) EXPECT_TRUE(std::isinf(d) || d <= 0.03 + surface.longest_edge);
  EXPECT_LT(used.reached.size(), 400u);
}

// The distance follows the surface around a thin edge, not through the body.
TEST(RhombusGeodesic, FollowsSurfaceAroundEdge) {
  const Surface surface = test::slab(0.2, 40, 0);  // 25 mm thick
  GeodesicField field;
  const TrianglePoint source = nearest(surface, {0.0901, 0.0003, 0});
  measure_distances(surface, source, 0.08, field);
  for (std::size_t v = 0; v < surface.vertices.size(); v++) {
    const Vec3d x = surface.vertices[v];
    if (x.z > -0.02 || std::abs(x.x - 0.09) > 1e-6 || std::abs(x.y) > 1e-6) continue;
    EXPECT_NEAR(field.distance[v], 0.0099 + 0.025 + 0.01,
                1e-5);  // to the edge, down the side, and back on the bottom
  }
}

}  // namespace
}  // namespace turgor::rhombus

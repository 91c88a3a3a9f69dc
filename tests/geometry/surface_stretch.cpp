// Largest principal stretch of surfaces with a known deformation.
#include "turgor/geometry/surface_stretch.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// Strip of 12 × 5 squares in the plane with unit axes along it and across it.
struct Strip {
  std::vector<Vec3> rest;
  std::vector<Int3> triangles;

  Strip(Vec3d along, Vec3d across) {
    constexpr int kColumns = 12, kRows = 5;
    for (int r = 0; r <= kRows; r++)
      for (int c = 0; c <= kColumns; c++) rest.emplace_back(along * (0.004 * c) + across * (0.003 * r));
    for (int r = 0; r < kRows; r++)
      for (int c = 0; c < kColumns; c++) {
        const int v = r * (kColumns + 1) + c, up = v + kColumns + 1;
        triangles.insert(triangles.end(), {{v, v + 1, up + 1}, {v, up + 1, up}});
      }
  }
};

// A strip in any plane that is stretched along any direction and narrows across has that factor everywhere,
// in any position.
TEST(SurfaceStretch, StretchedStripHasFactor) {
  const Vec3d along = normalized(Vec3d{1, 2, 0.5}), across = normalized(cross(along, {0.3, -1, 2}));
  const Vec3d up = cross(along, across);
  const Strip strip(along, across);
  for (const double factor : {1.27, 1.03, 2.5}) {
    for (const double angle : {0.0, 0.7, 1.9}) {
      const Vec3d pulled = along * std::cos(angle) + across * std::sin(angle), other = cross(up, pulled);
      std::vector<Vec3> now;
      for (const Vec3 x : strip.rest) {
        const Vec3d moved =
            pulled * (factor * dot(Vec3d(x), pulled)) + other * (dot(Vec3d(x), other) / std::sqrt(factor));
        // turned about an axis outside of the plane, and moved
        now.emplace_back(Vec3d{moved.y, moved.z, moved.x} + Vec3d{0.3, -0.2, 0.1});
      }
      for (const float stretch : principal_stretches(strip.rest, now, strip.triangles))
        EXPECT_NEAR(double(stretch), factor, 1e-4 * factor);
    }
  }
}

// Simple shear by γ stretches by γ/2 + √(1 + γ²/4), although no area changes.
TEST(SurfaceStretch, ShearHasClosedForm) {
  const Strip strip({1, 0, 0}, {0, 1, 0});
  for (const double shear : {0.1, 0.8}) {
    std::vector<Vec3> now;
    for (const Vec3 x : strip.rest)
      now.emplace_back(Vec3d{double(x.x) + shear * double(x.y), double(x.y), 0});
    const double largest = shear / 2 + std::sqrt(1 + shear * shear / 4);
    for (const float stretch : principal_stretches(strip.rest, now, strip.triangles))
      EXPECT_NEAR(double(stretch), largest, 1e-4);
  }
}

// Vertices without triangles, and triangles without area, have no stretch.
TEST(SurfaceStretch, DegenerateTrianglesAreLeftOut) {
  const std::vector<Vec3> rest = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {5, 5, 5}};
  const std::vector<Int3> triangles = {{0, 1, 2}, {0, 2, 3}};
  std::vector<Vec3> now = rest;
  for (Vec3& x : now) x = x * Real(1.5);
  const std::vector<float> stretch = principal_stretches(rest, now, triangles);
  EXPECT_EQ(stretch[4], 1);
  EXPECT_EQ(stretch[1], 1);
  EXPECT_NEAR(double(stretch[0]), 1.5, 1e-6);
}

// A thin triangle that is stretched ten times decides the largest vertex, and hardly a disc. A stretched
// region that is as large as the disc has its own stretch, on two meshes.
TEST(SurfaceStretch, DiscsDoNotFollowThinTriangles) {
  struct Sheet {
    std::vector<Vec3d> vertices;
    std::vector<Int3> triangles;
  };
  const auto sheet = [](double edge) {
    Sheet mesh;
    const int count = int(std::lround(0.06 / edge));
    for (int j = 0; j <= count; j++)
      for (int i = 0; i <= count; i++) mesh.vertices.push_back({i * edge, j * edge, 0});
    for (int j = 0; j < count; j++)
      for (int i = 0; i < count; i++) {
        const int a = j * (count + 1) + i, b = a + 1, c = a + count + 1, d = c + 1;
        mesh.triangles.push_back({a, b, d}), mesh.triangles.push_back({a, d, c});
      }
    return mesh;
  };
  for (const double edge : {0.002, 0.0013}) {
    Sheet mesh = sheet(edge);
    std::vector<Vec3> rest, now;
    for (const Vec3d x : mesh.vertices) rest.emplace_back(x);
    // stretched by 1.3 between x = 20 and 40 mm
    for (const Vec3d x : mesh.vertices)
      now.emplace_back(Vec3d{x.x + 0.3 * std::clamp(x.x - 0.02, 0.0, 0.02), x.y, 0});
    // a sliver at the corner
    const int first = int(rest.size());
    for (const double y : {0.0, 2e-5})
      rest.emplace_back(Vec3d{0.001, y, 0}), now.emplace_back(Vec3d{0.001 + 10 * y, y, 0});
    rest.emplace_back(Vec3d{0.002, 0, 0}), now.emplace_back(Vec3d{0.012, 0, 0});
    mesh.triangles.push_back({first, first + 1, first + 2});
    const std::vector<float> map = principal_stretches(rest, now, mesh.triangles);
    EXPECT_GT(*std::max_element(map.begin(), map.end()), 5);
    const DiscStretch most = largest_stretch_of_discs(rest, now, mesh.triangles, 0.005);
    EXPECT_NEAR(most.mean, 1.3, 1e-3) << edge;
    EXPECT_GT(rest[most.vertex].x, Real(0.024));
    EXPECT_LT(rest[most.vertex].x, Real(0.036));
  }
}

}  // namespace
}  // namespace turgor

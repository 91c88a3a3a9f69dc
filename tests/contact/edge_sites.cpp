// Sites of sharp edges that cross, against the distance of two lines.
#include <cmath>

#include <gtest/gtest.h>

#include "turgor/contact/pair_sites.hpp"
#include "turgor/geometry/pose.hpp"

namespace turgor::contact {
namespace {

/// A box with twelve triangles, counter-clockwise seen from outside.
struct PlainBox {
  std::vector<Vec3d> x;
  std::vector<Int3> triangles;

  explicit PlainBox(Vec3d size, const Pose& pose) {
    for (int n = 0; n < 8; n++) {
      const Vec3d at{(n & 1 ? 0.5 : -0.5) * size.x, (n & 2 ? 0.5 : -0.5) * size.y,
                     (n & 4 ? 0.5 : -0.5) * size.z};
      x.push_back(to_world(pose, at));
    }
    triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  }
  PairSurface surface(int body) const { return {body, x, x, triangles, {}}; }
};

Mat3d turned_axes(double about_x, double about_z) {
  const double c = std::cos(about_x), s = std::sin(about_x), cz = std::cos(about_z), sz = std::sin(about_z);
  const Mat3d x{{{1, 0, 0}, {0, c, s}, {0, -s, c}}}, z{{{cz, sz, 0}, {-sz, cz, 0}, {0, 0, 1}}};
  return z * x;
}

// Two planks across each other: the four crossings of the edges of the faces that meet, with the distance
// between the faces, above and inside.
TEST(EdgeSites, CrossedPlanks_MeetAtFourCrossings) {
  for (const double gap : {1e-3, -2e-3}) {
    const PlainBox low({0.2, 0.04, 0.02}, {{}, turned_axes(0, 0)});
    const PlainBox high({0.04, 0.2, 0.02}, {{0.01, 0.005, 0.02 + gap}, turned_axes(0, 0)});
    const std::vector<PairSite> sites =
        find_edge_sites({high.surface(0), low.surface(1)}, {.reach = 0.002, .deepest = 0.008}, {});
    ASSERT_EQ(sites.size(), 4U) << gap;
    for (const PairSite& site : sites) {
      EXPECT_LT(norm(site.normal - Vec3d{0, 0, 1}), 1e-12);
      EXPECT_NEAR(site.distance, gap, 1e-12);
      EXPECT_NEAR(std::abs(site.a.rest.x - 0.01), 0.02, 1e-12);
      EXPECT_NEAR(std::abs(site.b.rest.y), 0.02, 1e-12);
      EXPECT_LT(norm(site.a.rest - site.b.rest - Vec3d{0, 0, gap}), 1e-12);
    }
  }
}

// Two planks edge on edge at several angles: one crossing, with the distance of the two lines.
TEST(EdgeSites, EdgeOnEdge_HasDistanceOfLines) {
  constexpr double kEighth = 0.785398163397448;
  for (const double angle : {0.4, 1.0, 1.5}) {
    const double half = 0.02 * std::sqrt(0.5);
    const PlainBox low({0.2, 0.02, 0.02}, {{}, turned_axes(kEighth, 0)});
    const PlainBox high({0.2, 0.02, 0.02}, {{0.003, -0.002, 2 * half + 5e-4}, turned_axes(kEighth, angle)});
    const std::vector<PairSite> sites =
        find_edge_sites({high.surface(0), low.surface(1)}, {.reach = 0.002, .deepest = 0.004}, {});
    ASSERT_EQ(sites.size(), 1U) << angle;
    EXPECT_LT(norm(sites[0].normal - Vec3d{0, 0, 1}), 1e-9);
    EXPECT_NEAR(sites[0].distance, 5e-4, 1e-9);
  }
}

// Boxes that lie on each other with parallel edges have no crossing: vertices touch there.
TEST(EdgeSites, ParallelEdges_HaveNone) {
  const PlainBox low({0.1, 0.1, 0.02}, {{}, turned_axes(0, 0)});
  const PlainBox high({0.04, 0.04, 0.02}, {{0.003, 0, 0.0201}, turned_axes(0, 0)});
  EXPECT_TRUE(
      find_edge_sites({high.surface(0), low.surface(1)}, {.reach = 0.002, .deepest = 0.008}, {}).empty());
}

}  // namespace
}  // namespace turgor::contact

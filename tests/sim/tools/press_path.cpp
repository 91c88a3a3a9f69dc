#include "turgor/sim/tools/press_path.hpp"

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"

namespace turgor {
namespace {

struct Block {
  SolidMesh mesh = hex_block({0.1, 0.06, 0.04}, {10, 6, 4});
  SolidSurface outer = surface(mesh);
  RestSurface rest() const { return {mesh.vertices, outer.triangles}; }
};

TEST(PressPath, AFractionOfOneMeansTheSurfaceSeenFromThatSide) {
  const Block block;
  const SurfaceSample top = place_on_surface(block.rest(), {0.5, 0.5, 1}, true, 0.01);
  EXPECT_NEAR(norm(top.point - Vec3d{0.05, 0.03, 0.04}), 0, 1e-12);
  EXPECT_NEAR(norm(top.normal - Vec3d{0, 0, 1}), 0, 1e-12);
  const SurfaceSample front = place_on_surface(block.rest(), {0.25, 0, 0.5}, true, 0.01);
  EXPECT_NEAR(norm(front.point - Vec3d{0.025, 0, 0.02}), 0, 1e-12);
  EXPECT_NEAR(norm(front.normal - Vec3d{0, -1, 0}), 0, 1e-12);
}

TEST(PressPath, APlaceInMetersIsMovedToTheNearestPointOfTheSurface) {
  const SurfaceSample place = place_on_surface(Block().rest(), {0.05, 0.03, 0.07}, false, 0.01);
  EXPECT_NEAR(norm(place.point - Vec3d{0.05, 0.03, 0.04}), 0, 1e-12);
}

TEST(PressPath, TheTipGoesToTheDepthSlidesThereAndLeaves) {
  const Block block;
  const Press press{.at = {0.3, 0.5, 1},
                    .to = {0.7, 0.5, 1},
                    .by_fraction = true,
                    .depth = 0.003,
                    .start = 0.1,
                    .duration = 0.4,
                    .hold = 0.2,
                    .slide = 1};
  const double radius = 0.005;
  const ToolPath path = press_path(block.rest(), press, radius, radius);
  const auto tip = [&](double time) { return path_at(path, time).position - Vec3d{0, 0, radius}; };
  EXPECT_GT(tip(0).z, 0.04) << "outside before it starts";
  EXPECT_NEAR(norm(tip(0.5) - Vec3d{0.03, 0.03, 0.037}), 0, 1e-12);
  EXPECT_NEAR(norm(tip(0.7) - Vec3d{0.03, 0.03, 0.037}), 0, 1e-12);
  EXPECT_NEAR(norm(tip(1.2) - Vec3d{0.05, 0.03, 0.037}), 0, 1e-9);
  EXPECT_NEAR(norm(tip(1.7) - Vec3d{0.07, 0.03, 0.037}), 0, 1e-12);
  EXPECT_GT(tip(2.3).z, 0.04) << "outside when it is over";
}

}  // namespace
}  // namespace turgor

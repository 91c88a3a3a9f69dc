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

// A fraction of 0 or 1 selects the surface as seen from that side.
TEST(PressPath, FractionSelectsSurfaceFromSide) {
  const Block block;
  const SurfaceSample top = sample_surface(block.rest(), {0.5, 0.5, 1}, true, 0.01);
  EXPECT_NEAR(norm(top.point - Vec3d{0.05, 0.03, 0.04}), 0, 1e-12);
  EXPECT_NEAR(norm(top.normal - Vec3d{0, 0, 1}), 0, 1e-12);
  const SurfaceSample front = sample_surface(block.rest(), {0.25, 0, 0.5}, true, 0.01);
  EXPECT_NEAR(norm(front.point - Vec3d{0.025, 0, 0.02}), 0, 1e-12);
  EXPECT_NEAR(norm(front.normal - Vec3d{0, -1, 0}), 0, 1e-12);
}

// A position in meters is moved to the nearest point of the surface.
TEST(PressPath, PositionMovesToNearestPoint) {
  const SurfaceSample sample = sample_surface(Block().rest(), {0.05, 0.03, 0.07}, false, 0.01);
  EXPECT_NEAR(norm(sample.point - Vec3d{0.05, 0.03, 0.04}), 0, 1e-12);
}

// The tip presses to the depth, slides at that depth and leaves.
TEST(PressPath, TipPressesSlidesAndLeaves) {
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
  EXPECT_GT(tip(0).z, 0.04) << "outside before the start";
  EXPECT_NEAR(norm(tip(0.5) - Vec3d{0.03, 0.03, 0.037}), 0, 1e-12);
  EXPECT_NEAR(norm(tip(0.7) - Vec3d{0.03, 0.03, 0.037}), 0, 1e-12);
  EXPECT_NEAR(norm(tip(1.2) - Vec3d{0.05, 0.03, 0.037}), 0, 1e-9);
  EXPECT_NEAR(norm(tip(1.7) - Vec3d{0.07, 0.03, 0.037}), 0, 1e-12);
  EXPECT_GT(tip(2.3).z, 0.04) << "outside at the end";
}

}  // namespace
}  // namespace turgor

#include "turgor/view/camera.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

// A framed box fills the picture and is not clipped, from any direction.
TEST(Camera, FramedBoxFillsPicture) {
  const Box box{{-0.1, -0.2, 0.3}, {0.3, 0.1, 0.9}};
  constexpr int kWidth = 960, kHeight = 720;
  for (const Vec3d direction : {Vec3d{0, -1, 0}, {1, 0, 0}, {0.4, -1, 0.3}, {0, 0, 1}, {-2, 3, -1}}) {
    const Camera camera = frame_box(box, direction, {0, 0, 1}, double(kWidth) / kHeight);
    double reach = 0;
    for (int i = 0; i < 8; i++) {
      const Vec3d corner{i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                         i & 4 ? box.high.z : box.low.z};
      const Vec3d seen = test::project(camera, corner, kWidth, kHeight);
      EXPECT_GT(seen.z, 0);
      reach = std::max({reach, std::abs(2 * seen.x / kWidth - 1), std::abs(2 * seen.y / kHeight - 1)});
    }
    EXPECT_LT(reach, 1);
    EXPECT_GT(reach, 0.85);
  }
}

// A margin on the right keeps the visible content and the viewing direction.
TEST(Camera, MarginRightKeepsContent) {
  const Camera whole{.eye = {0.3, -2, 0.4}, .target = {0.1, 0, 0.2}, .up = {0, 0, 1}, .field_of_view = 35};
  const double aspect = 1.5, margin = 0.25;
  const CameraFrame frame = camera_frame(whole);
  const double half = norm(whole.eye - whole.target) * frame.tan_half * aspect;
  const Camera moved = with_margin_right(whole, aspect, margin);
  const CameraFrame after = camera_frame(moved);
  EXPECT_NEAR(norm(after.back - frame.back), 0, 1e-12) << "the viewing direction is kept";
  const auto across = [&](Vec3d point) {  // -1 at the left edge, 1 at the right one
    const Vec3d seen = point - moved.eye;
    return dot(seen, after.right) / (-dot(seen, after.back) * after.tan_half * aspect);
  };
  EXPECT_NEAR(across(whole.target - frame.right * half), -1, 1e-9);
  EXPECT_NEAR(across(whole.target + frame.right * half), 1 - 2 * margin, 1e-9);
}

// The camera frame is orthonormal even if the up vector is parallel to the line of sight.
TEST(Camera, FrameIsOrthonormalWhenUpIsParallel) {
  const CameraFrame frame = camera_frame({.eye = {0, 0, 2}, .target = {0, 0, 0}, .up = {0, 0, 1}});
  EXPECT_NEAR(norm(frame.right), 1, 1e-12);
  EXPECT_NEAR(norm(frame.up), 1, 1e-12);
  EXPECT_NEAR(dot(frame.right, frame.up), 0, 1e-12);
  EXPECT_NEAR(dot(cross(frame.right, frame.up), frame.back), 1, 1e-12);
}

// The bounding box of a flipped grid includes whole samples.
TEST(Camera, FlippedGridBoxHoldsWholeSamples) {
  const Grid grid{.size = {10, 20, 5},
                  .spacing = {0.001, 0.002, 0.003},
                  .origin = {0.1, 0, 0},
                  .axes = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  const Box box = bounding_box(grid);
  EXPECT_NEAR(box.high.x, 0.1 + 0.0005, 1e-12);
  EXPECT_NEAR(box.low.x, 0.1 - 9.5 * 0.001, 1e-12);
  EXPECT_NEAR(box.high.y - box.low.y, 0.040, 1e-12);
  EXPECT_NEAR(box.high.z, 4.5 * 0.003, 1e-12);
}

// The bounding box of an empty mesh is zero.
TEST(Camera, EmptyMeshBoxIsZero) { EXPECT_EQ(bounding_box(TriMesh{}).high, Vec3d{}); }

}  // namespace
}  // namespace turgor

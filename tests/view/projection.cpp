#include "turgor/view/projection.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

Vec3d transform(const Mat4& m, Vec3d p) {
  double clip[4];
  for (std::size_t row = 0; row < 4; row++)
    clip[row] =
        double(m[row]) * p.x + double(m[4 + row]) * p.y + double(m[8 + row]) * p.z + double(m[12 + row]);
  return Vec3d{clip[0], clip[1], clip[2]} / clip[3];
}

constexpr Box kBoxes[] = {{{-0.1, -0.2, 0.3}, {0.3, 0.1, 0.9}}, {{0.2, 0, 0}, {0.25, 0.1, 0.1}}};

// The camera matrix projects points like the camera.
TEST(Projection, CameraMatrixMatchesCamera) {
  const Camera camera{.eye = {0.5, -2, 0.8}, .target = {0.1, 0, 0.4}};
  const View view = make_view(kBoxes, camera, 4.0 / 3);
  for (const Box& box : kBoxes) {
    for (int i = 0; i < 8; i++) {
      const Vec3d clip = transform(camera_matrix(view), corner(box, i));
      const Vec3d seen = test::project(camera, corner(box, i), 400, 300);
      EXPECT_NEAR(200 + 200 * clip.x, seen.x, 0.01);
      EXPECT_NEAR(150 - 150 * clip.y, seen.y, 0.01);
      EXPECT_LT(std::abs(clip.z), 1);
    }
  }
}

// The near plane stays in front of the eye, even if the eye is inside a body.
TEST(Projection, NearPlaneIsPositive) {
  const View inside = make_view(kBoxes, {.eye = {0, 0, 0.5}, .target = {0, 1, 0.5}}, 1);
  EXPECT_GT(inside.near, 0);
  EXPECT_LT(inside.near, inside.far);
  const View nothing = make_view({}, {.eye = {0, -1, 0}, .target = {}}, 1);
  EXPECT_LT(nothing.near, nothing.far);
}

// The view of the light contains all boxes; points nearer to the light have smaller depth.
TEST(Projection, LightViewContainsBoxes) {
  for (const Vec3d light : {Vec3d{0, 0, 1}, {-0.7, 0.5, 0.6}, {1, 0, 0}}) {
    const Mat4 m = make_light_view(kBoxes, light).matrix;
    for (const Box& box : kBoxes) {
      for (int i = 0; i < 8; i++) {
        const Vec3d seen = transform(m, corner(box, i));
        for (int axis = 0; axis < 3; axis++) EXPECT_LE(std::abs(seen[axis]), 1 + 1e-5);
        EXPECT_LT(transform(m, corner(box, i) + light * 0.1).z, seen.z);
      }
    }
  }
}

}  // namespace
}  // namespace turgor

#include "turgor/window/camera_moves.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace turgor {
namespace {

constexpr double kAspect = 1.4;
constexpr Camera kCamera{.eye = {0.3, -1.2, 0.4}, .target = {0.05, 0.1, 0.02}, .up = {0, 0, 1}};
constexpr Vec3d kPoints[] = {{0, 0, 0}, {0.2, 0.1, -0.15}, {-0.1, 0.3, 0.22}};

double distance(const Camera& camera) { return norm(camera.eye - camera.target); }

// The ray through the projection of a point passes through the point.
TEST(CameraMoves, SightRayPassesThroughPoint) {
  for (const Vec3d point : kPoints) {
    const auto seen = project(kCamera, point, kAspect);
    ASSERT_TRUE(seen);
    const SightRay ray = sight_ray(kCamera, *seen, kAspect);
    EXPECT_LT(norm(cross(point - ray.from, ray.direction)), 1e-12);
  }
  EXPECT_FALSE(project(kCamera, kCamera.eye * 2.0 - kCamera.target, kAspect)) << "behind the eye";
}

// Orbiting keeps target and distance and is reversible.
TEST(CameraMoves, OrbitKeepsTargetAndDistance) {
  const Camera turned = orbited(kCamera, 0.7, 0.3), back = orbited(turned, -0.7, -0.3);
  EXPECT_EQ(turned.target, kCamera.target);
  EXPECT_NEAR(distance(turned), distance(kCamera), 1e-12);
  EXPECT_LT(norm(back.eye - kCamera.eye), 1e-12);
  EXPECT_GT(norm(turned.eye - kCamera.eye), 0.3);
  const Camera round = orbited(kCamera, 2 * std::numbers::pi, 0);
  EXPECT_LT(norm(round.eye - kCamera.eye), 1e-12);
}

// Orbiting stops before the poles.
TEST(CameraMoves, OrbitStopsBeforePoles) {
  const Camera above = orbited(kCamera, 0, 10);
  EXPECT_GT(above.eye.z - above.target.z, 0.99 * distance(kCamera));
  EXPECT_GT(dot(camera_frame(above).right, camera_frame(kCamera).right), 0.999)
      << "the picture does not flip";
}

// Panning moves the point at one screen position to another.
TEST(CameraMoves, PanMovesPointToCursor) {
  const ScreenPosition from{-0.3, 0.2}, to{0.5, -0.4};
  const Vec3d point = in_plane(kCamera, sight_ray(kCamera, from, kAspect), kCamera.target);
  const auto seen = project(panned(kCamera, from, to, kAspect), point, kAspect);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x, to.x, 1e-9);
  EXPECT_NEAR(seen->y, to.y, 1e-9);
}

// Zooming keeps the point under the cursor.
TEST(CameraMoves, ZoomKeepsPointUnderCursor) {
  const ScreenPosition cursor{0.6, -0.5};
  const Vec3d point = in_plane(kCamera, sight_ray(kCamera, cursor, kAspect), kCamera.target);
  for (const double factor : {0.5, 0.9, 1.7}) {
    const Camera zoomed_camera = zoomed(kCamera, factor, cursor, kAspect);
    const auto seen = project(zoomed_camera, point, kAspect);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, cursor.x, 1e-9);
    EXPECT_NEAR(seen->y, cursor.y, 1e-9);
    EXPECT_NEAR(distance(zoomed_camera), factor * distance(kCamera), 1e-12);
  }
}

// Standard views show the whole box in the usual orientation of the patient.
TEST(CameraMoves, StandardViewsShowWholeBox) {
  const Box box{{-0.2, -0.1, -0.4}, {0.2, 0.15, 0.4}};
  using V = StandardView;
  const Vec3d left{0.15, 0, 0}, back{0, 0.12, 0}, head{0, 0, 0.35};
  for (const V view : {V::kFront, V::kBack, V::kRight, V::kLeft, V::kHead, V::kFeet}) {
    const Camera camera = standard_view(view, box, kAspect);
    for (int i = 0; i < 8; i++) {
      const auto seen = project(camera, corner(box, i), kAspect);
      ASSERT_TRUE(seen);
      EXPECT_LE(std::max(std::abs(seen->x), std::abs(seen->y)), 1);
    }
  }
  const auto x_of = [&](V view, Vec3d p) {
    return project(standard_view(view, box, kAspect), p, kAspect)->x;
  };
  const auto y_of = [&](V view, Vec3d p) {
    return project(standard_view(view, box, kAspect), p, kAspect)->y;
  };
  EXPECT_GT(x_of(V::kFront, left), 0) << "the patient's left is on the right, as if face to face";
  EXPECT_LT(x_of(V::kBack, left), 0);
  EXPECT_GT(y_of(V::kFront, head), 0);
  EXPECT_LT(x_of(V::kLeft, {0, -0.1, 0}), x_of(V::kLeft, back))
      << "seen from the left the front is on the left";
  EXPECT_GT(x_of(V::kRight, {0, -0.1, 0}), x_of(V::kRight, back));
  EXPECT_GT(y_of(V::kHead, back), y_of(V::kHead, {0, -0.1, 0})) << "from the head the back is above";
}

// Focusing sets the target and keeps the viewing direction.
TEST(CameraMoves, FocusKeepsDirection) {
  const Camera camera = focused(kCamera, kPoints[1], 0.4);
  EXPECT_EQ(camera.target, kPoints[1]);
  EXPECT_NEAR(distance(camera), 0.4, 1e-12);
  EXPECT_NEAR(dot(camera_frame(camera).back, camera_frame(kCamera).back), 1, 1e-12);
}

}  // namespace
}  // namespace turgor

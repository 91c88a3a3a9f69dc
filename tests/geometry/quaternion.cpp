#include "turgor/geometry/quaternion.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace turgor {
namespace {

Quaternion about(Vec3d axis, double angle) {
  const Vec3d v = axis * std::sin(angle / 2);
  return {std::cos(angle / 2), v.x, v.y, v.z};
}

// Rotations follow the right-hand rule.
TEST(Quaternion, RotatesByRightHandRule) {
  const Mat3d turned = axes_of(about({0, 0, 1}, 0.3));
  EXPECT_NEAR(norm(turned.column[0] - Vec3d{std::cos(0.3), std::sin(0.3), 0}), 0, 1e-15);
  EXPECT_NEAR(norm(turned.column[2] - Vec3d{0, 0, 1}), 0, 1e-15);
}

// Interpolation at one half gives half the angle for either sign of a quaternion.
TEST(Quaternion, InterpolatesHalfAngle) {
  const Vec3d axis = normalized(Vec3d{1, -2, 0.5});
  const Quaternion a = about(axis, 0.2), b = about(axis, 1.4), half = about(axis, 0.8);
  Quaternion minus_b = b;
  for (double& component : minus_b) component = -component;
  for (const Quaternion& other : {b, minus_b})
    EXPECT_NEAR(std::abs(dot(between(a, other, 0.5), half)), 1, 1e-12);
}

}  // namespace
}  // namespace turgor

#include "turgor/geometry/quaternion.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace turgor {
namespace {

Quaternion about(Vec3d axis, double angle) {
  const Vec3d v = axis * std::sin(angle / 2);
  return {std::cos(angle / 2), v.x, v.y, v.z};
}

TEST(Quaternion, axes_are_turned_by_the_right_hand) {
  const Mat3d turned = axes_of(about({0, 0, 1}, 0.3));
  EXPECT_NEAR(norm(turned.column[0] - Vec3d{std::cos(0.3), std::sin(0.3), 0}), 0, 1e-15);
  EXPECT_NEAR(norm(turned.column[2] - Vec3d{0, 0, 1}), 0, 1e-15);
}

TEST(Quaternion, halfway_between_two_is_half_the_angle_whatever_their_signs) {
  const Vec3d axis = normalized(Vec3d{1, -2, 0.5});
  const Quaternion a = about(axis, 0.2), b = about(axis, 1.4), half = about(axis, 0.8);
  Quaternion minus_b = b;
  for (double& part : minus_b) part = -part;
  for (const Quaternion& other : {b, minus_b})
    EXPECT_NEAR(std::abs(dot(between(a, other, 0.5), half)), 1, 1e-12);
}

}  // namespace
}  // namespace turgor

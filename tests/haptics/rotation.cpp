#include "turgor/haptics/rotation.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "turgor/contact/tool.hpp"

namespace turgor::haptics {

// The rotation vector of a rotation is the vector from which it was built.
TEST(Rotation, RotationVectorRoundTrips) {
  const double pi = std::numbers::pi;
  for (const double angle : {1e-9, 1e-4, 0.3, 1.5, 3.0, pi - 1e-6})
    for (const Vec3d axis : {Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, Vec3d{0.6, 0, -0.8}, Vec3d{-0.48, 0.6, 0.64}}) {
      const Mat3d m = rotation(axis * angle);
      EXPECT_TRUE(contact::is_valid({.position = {}, .axes = m}));
      EXPECT_LT(norm(rotation_vector(m) - axis * angle), 1e-9) << angle;
    }
  EXPECT_EQ(norm(rotation_vector(Mat3d{})), 0);
}

// A quarter turn about z maps x to y.
TEST(Rotation, QuarterTurnAboutZMapsXToY) {
  const Vec3d turned = rotation({0, 0, std::numbers::pi / 2}) * Vec3d{1, 0, 0};
  EXPECT_LT(norm(turned - Vec3d{0, 1, 0}), 1e-12);
}

}  // namespace turgor::haptics

#include "turgor/core/vec.hpp"

#include <gtest/gtest.h>

namespace turgor {

// The inverse of a matrix times the matrix is the identity.
TEST(Vec, InverseTimesMatrixIsIdentity) {
  const Mat3d m{{{2, 1, 0}, {-1, 3, 0.5}, {0.25, 0, 1}}};
  const Mat3d product = inverse(m) * m;
  for (int column = 0; column < 3; column++)
    for (int row = 0; row < 3; row++) EXPECT_NEAR(product.column[column][row], row == column ? 1 : 0, 1e-14);
}

// The cross product is orthogonal to both of its factors.
TEST(Vec, CrossProductIsOrthogonal) {
  const Vec3d a{1, 2, 3}, b{-2, 0.5, 4};
  EXPECT_NEAR(dot(cross(a, b), a), 0, 1e-14);
  EXPECT_NEAR(dot(cross(a, b), b), 0, 1e-14);
}

}  // namespace turgor

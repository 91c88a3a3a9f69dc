#include "turgor/window/cut_preview.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

// On a ball the line is the arc of a great circle between both points, and it leaves the far side out.
TEST(CutPreview, LineOnBallIsGreatArc) {
  constexpr double kRadius = 0.1;
  const TriMesh ball = test::sphere({0, 0, 0}, float(kRadius), 96);
  const double angle = 0.8;  // between both points [rad]
  const Vec3d a{std::sin(-angle / 2), -std::cos(angle / 2), 0},
      b{std::sin(angle / 2), -std::cos(angle / 2), 0};
  const SkinLine line = line_on_skin(ball.vertices, ball.triangles, a * kRadius, a, b * kRadius, b);
  EXPECT_NEAR(line.length, angle * kRadius, 0.01 * kRadius);
  EXPECT_LT(norm(line.outward - Vec3d{0, -1, 0}), 1e-9);
  for (const SkinLine::Piece& piece : line.pieces) {
    EXPECT_NEAR(piece.from.z, 0, 1e-6);
    EXPECT_NEAR(norm(piece.to), kRadius, 0.01 * kRadius);
    EXPECT_LT(piece.to.y, 0) << "not on the far side";
  }
}

// Equal points and normals along the line have no plane.
TEST(CutPreview, DegenerateLinesAreEmpty) {
  const TriMesh ball = test::sphere({0, 0, 0}, 0.1f, 16);
  const Vec3d p{0, -0.1, 0}, n{0, -1, 0};
  EXPECT_TRUE(line_on_skin(ball.vertices, ball.triangles, p, n, p, n).pieces.empty());
  EXPECT_TRUE(line_on_skin(ball.vertices, ball.triangles, p, n, p + n, n).pieces.empty());
}

}  // namespace
}  // namespace turgor

#include "turgor/window/pick.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

BodySnapshot ball(Vec3 center, float radius) {
  const TriMesh mesh = test::sphere(center, radius, 64);
  BodySnapshot body;
  body.x = mesh.vertices, body.triangles = mesh.triangles;
  return body;
}

// The picked point of a ball and its normal match the analytic intersection.
TEST(Pick, FindsNearestPointAndNormal) {
  WorldSnapshot snapshot;
  snapshot.bodies = {ball({0.1f, 0.2f, -0.1f}, 0.08f)};
  const Vec3d center{0.1, 0.2, -0.1}, from{0.7, -0.5, 0.4}, beside{0.12, 0.21, -0.07};
  const SightRay ray{from, normalized(beside - from)};
  const auto found = pick(snapshot, ray);
  ASSERT_TRUE(found);
  const double along = dot(center - from, ray.direction),
               away2 = dot(center - from, center - from) - along * along;
  const Vec3d expected = from + ray.direction * (along - std::sqrt(0.08 * 0.08 - away2));
  EXPECT_LT(norm(found->point - expected), 2e-4);
  EXPECT_GT(dot(found->normal, normalized(expected - center)), 0.998);
}

// The body in front hides the one behind it, in either order.
TEST(Pick, FrontBodyHidesOther) {
  WorldSnapshot snapshot;
  snapshot.bodies = {ball({0, 0.5f, 0}, 0.1f), ball({0, 0, 0}, 0.1f)};
  const auto found = pick(snapshot, {{0, -1, 0}, {0, 1, 0}});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->body, 1u);
  EXPECT_NEAR(found->distance, 0.9, 1e-3);
}

// Rays beside a body, and bodies behind the eye, give no result.
TEST(Pick, MissesBesideAndBehindEye) {
  WorldSnapshot snapshot;
  snapshot.bodies = {ball({0, 0, 0}, 0.1f)};
  EXPECT_FALSE(pick(snapshot, {{0.2, -1, 0}, {0, 1, 0}}));
  EXPECT_FALSE(pick(snapshot, {{0, -1, 0}, {0, -1, 0}}));
}

}  // namespace
}  // namespace turgor

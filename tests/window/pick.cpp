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

TEST(pick, the_nearest_place_of_a_ball_on_a_ray_is_where_geometry_says_with_its_normal) {
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

TEST(pick, the_body_in_front_hides_the_one_behind_it_whatever_their_order) {
  WorldSnapshot snapshot;
  snapshot.bodies = {ball({0, 0.5f, 0}, 0.1f), ball({0, 0, 0}, 0.1f)};
  const auto found = pick(snapshot, {{0, -1, 0}, {0, 1, 0}});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->body, 1u);
  EXPECT_NEAR(found->distance, 0.9, 1e-3);
}

TEST(pick, nothing_lies_beside_a_body_and_nothing_behind_the_eye) {
  WorldSnapshot snapshot;
  snapshot.bodies = {ball({0, 0, 0}, 0.1f)};
  EXPECT_FALSE(pick(snapshot, {{0.2, -1, 0}, {0, 1, 0}}));
  EXPECT_FALSE(pick(snapshot, {{0, -1, 0}, {0, -1, 0}}));
}

}  // namespace
}  // namespace turgor

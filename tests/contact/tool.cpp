#include "turgor/contact/tool.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace turgor::contact {
namespace {

/// A box around the origin.
TriMesh box_mesh(Vec3d half) {
  TriMesh mesh;
  for (int corner = 0; corner < 8; corner++)
    mesh.vertices.push_back(
        Vec3({corner & 1 ? Real(half.x) : -Real(half.x), corner & 2 ? Real(half.y) : -Real(half.y),
              corner & 4 ? Real(half.z) : -Real(half.z)}));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

double box_distance(Vec3d half, Vec3d x) {
  const Vec3d q = Vec3d{std::abs(x.x), std::abs(x.y), std::abs(x.z)} - half;
  return norm(max(q, Vec3d{})) + std::min(0.0, std::max({q.x, q.y, q.z}));
}

Vec3d random_point(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  return {number(random), number(random), number(random)};
}

// Normals equal the gradients of distances.
TEST(Tool, NormalsAreDistanceGradients) {
  std::mt19937 random(1);
  for (const Shape& shape : {Shape(Sphere{3e-3}), Shape(Capsule{2e-3, 5e-3})}) {
    for (int i = 0; i < 1000; i++) {
      const Vec3d x = random_point(random, 0.01);
      const ShapeDistance d = distance(shape, x);
      const double h = 1e-7;
      const Vec3d gradient{(distance(shape, x + Vec3d{h, 0, 0}).distance - d.distance) / h,
                           (distance(shape, x + Vec3d{0, h, 0}).distance - d.distance) / h,
                           (distance(shape, x + Vec3d{0, 0, h}).distance - d.distance) / h};
      EXPECT_LT(norm(gradient - d.normal), 2e-3);
    }
  }
}

// The sampled distance of a box is exact to a fraction of the grid spacing.
TEST(Tool, BoxDistanceWithinGridSpacing) {
  const Vec3d half{4e-3, 3e-3, 2e-3};
  const Result<Shape> box = mesh_shape(box_mesh(half));
  ASSERT_TRUE(box) << box.error().message;
  const double spacing = std::get<MeshShape>(*box).spacing;
  std::mt19937 random(2);
  double near = 0, anywhere = 0, far = 0;  // `far`: beyond the grid, relative
  for (int i = 0; i < 20000; i++) {
    const Vec3d x = random_point(random, 4.6e-3), y = random_point(random, 2e-2);
    const double exact = box_distance(half, x), error = std::abs(distance(*box, x).distance - exact);
    (std::abs(exact) < spacing ? near : anywhere) =
        std::max(std::abs(exact) < spacing ? near : anywhere, error);
    if (std::max({std::abs(y.x), std::abs(y.y), std::abs(y.z)}) > 8e-3)
      far = std::max(far, std::abs(distance(*box, y).distance / box_distance(half, y) - 1));
  }
  EXPECT_LT(near, 0.5 * spacing);
  EXPECT_LT(anywhere, 1.5 * spacing);
  EXPECT_LT(far, 0.05);
  EXPECT_NEAR(norm(distance(*box, {0, 0, 2.1e-3}).normal - Vec3d{0, 0, 1}), 0, 1e-6);
  EXPECT_NEAR(distance(*box, {0.5e-3, 0.3e-3, 2.1e-3}).distance, 1e-4, 1e-8) << "flat sides are exact";
  EXPECT_NEAR(bounding_radius(*box), norm(half), 1e-8);
  EXPECT_NEAR(tip_radius(*box), 2e-3, 1e-8);
}

// The tips of a mesh lie on its surface and include its corners.
TEST(Tool, TipsLieOnSurfaceAndCorners) {
  const Vec3d half{4e-3, 3e-3, 2e-3};
  const Result<Shape> box = mesh_shape(box_mesh(half));
  ASSERT_TRUE(box);
  int corners = 0;
  for (int i = 0; i < tip_count(*box); i++) {
    EXPECT_NEAR(box_distance(half, tip(*box, i)), 0, 1e-9);
    corners += std::abs(norm(tip(*box, i)) - norm(half)) < 1e-9;
  }
  EXPECT_EQ(corners, 8);
}

// A pose moves a shape rigidly.
TEST(Tool, PoseMovesShapeRigidly) {
  const Pose pose{{1e-3, 2e-3, 3e-3}, {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}}};
  const Shape rod = Capsule{1e-3, 4e-3};  // its axis lies along the world's x
  EXPECT_NEAR(distance(rod, pose, pose.position + Vec3d{5e-3, 0, 0}).distance, 0, 1e-15);
  EXPECT_NEAR(distance(rod, pose, pose.position + Vec3d{2e-3, 0, 3e-3}).distance, 2e-3, 1e-15);
  EXPECT_LT(norm(distance(rod, pose, pose.position + Vec3d{2e-3, 0, 3e-3}).normal - Vec3d{0, 0, 1}), 1e-15);
  EXPECT_LT(norm(to_world(pose, to_tool(pose, {0.1, 0.2, 0.3})) - Vec3d{0.1, 0.2, 0.3}), 1e-15);
}

// Poses that are not finite or whose axes are not a rotation are invalid.
TEST(Tool, InvalidPosesAreDetected) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(is_valid({}));
  EXPECT_FALSE(is_valid({{nan, 0, 0}, {}}));
  EXPECT_FALSE(is_valid({{0, 0, INFINITY}, {}}));
  EXPECT_FALSE(is_valid({{}, {{{nan, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}));
  EXPECT_FALSE(is_valid({{}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}})) << "a reflection";
  EXPECT_FALSE(is_valid({{}, {{{1.1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}));
}

// No point of a triangle is closer than the point of the closest weights.
TEST(Tool, ClosestWeightsMinimizeDistance) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(0, 1);
  for (int i = 0; i < 2000; i++) {
    const Vec3d a = random_point(random, 1), b = random_point(random, 1), c = random_point(random, 1),
                x = random_point(random, 2);
    const Vec3d w = closest_weights(x, a, b, c);
    EXPECT_NEAR(w.x + w.y + w.z, 1, 1e-12);
    EXPECT_GE(std::min({w.x, w.y, w.z}), 0);
    const double nearest = norm(w.x * a + w.y * b + w.z * c - x);
    for (int j = 0; j < 50; j++) {
      double s = number(random), t = number(random);
      if (s + t > 1) s = 1 - s, t = 1 - t;
      EXPECT_LE(nearest, norm(a + s * (b - a) + t * (c - a) - x) + 1e-12);
    }
  }
}

// Meshes that are not closed or not finite are rejected; the message names the vertex.
TEST(Tool, RejectsMeshesThatAreNotClosed) {
  TriMesh open = box_mesh({1e-3, 1e-3, 1e-3});
  open.triangles.pop_back();
  EXPECT_NE(mesh_shape(open).error().message.find("not closed"), std::string::npos);
  TriMesh wild = box_mesh({1e-3, 1e-3, 1e-3});
  wild.vertices[3].x = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_NE(mesh_shape(wild).error().message.find("vertex 3"), std::string::npos);
  TriMesh lost = box_mesh({1e-3, 1e-3, 1e-3});
  lost.triangles[2].y = 99;
  EXPECT_NE(mesh_shape(lost).error().message.find("vertex 99"), std::string::npos);
  EXPECT_FALSE(mesh_shape({}));
  TriMesh flat = box_mesh({0, 0, 0});
  EXPECT_NE(mesh_shape(flat).error().message.find("extent"), std::string::npos);
}

}  // namespace
}  // namespace turgor::contact

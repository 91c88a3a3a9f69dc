#include "turgor/geometry/winding_number.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/geometry/shapes.hpp"

namespace turgor {
namespace {

struct Winding {
  TriangleTree tree;
  WindingNodes winding;

  explicit Winding(const TriMesh& mesh) {
    std::vector<Vec3d> x;
    for (const Vec3 p : mesh.vertices) x.push_back(Vec3d(p));
    tree = build_triangle_tree(std::move(x), mesh.triangles);
    winding = winding_nodes(tree);
  }
  double at(Vec3d p) const { return winding_number(tree, winding, p); }
};

// The winding number is one inside a closed surface and zero outside, also close to it.
TEST(WindingNumber, OneInsideZeroOutside) {
  const Winding ball(test::sphere_surface({}, 1, 4));
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; i++) {
    const Vec3d direction = normalized(Vec3d{normal(random), normal(random), normal(random)});
    EXPECT_NEAR(ball.at(direction * (0.99 * i / 1000)), 1, 0.03);
    EXPECT_NEAR(ball.at(direction * (1.01 + 0.01 * i)), 0, 0.03);
  }
}

// The winding number is two at points that the surface encloses twice.
TEST(WindingNumber, TwoWhereEnclosedTwice) {
  const Winding coil(test::coil_surface(1, 0.1, 0.5));
  EXPECT_NEAR(coil.at({1, 0, 0}), 2, 0.05);
  EXPECT_NEAR(coil.at({1.55, 0, 0}), 1, 0.05);
  EXPECT_NEAR(coil.at({0, 0, 0}), 0, 0.05);
}

// A hemisphere has a winding number of one half at its center.
TEST(WindingNumber, HalfSphereHasOneHalf) {
  TriMesh ball = test::sphere_surface({}, 1, 3);
  std::erase_if(ball.triangles, [&](const Int3& t) {
    return ball.vertices[std::size_t(t.x)].z + ball.vertices[std::size_t(t.y)].z +
               ball.vertices[std::size_t(t.z)].z <
           0;
  });
  EXPECT_NEAR(Winding(ball).at({}), 0.5, 0.03);
}

}  // namespace
}  // namespace turgor

#include "turgor/geometry/rounded.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "shapes.hpp"

namespace turgor {
namespace {

/// An octahedron with a spike on every face: a star of eight points.
TriMesh star(double point) {
  const TriMesh ball{.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                     .triangles = {},
                     .normals = {},
                     .scalars = {}};
  TriMesh mesh = ball;
  for (int n = 0; n < 8; n++) {
    const Int3 signs{n & 1 ? -1 : 1, n & 2 ? -1 : 1, n & 4 ? -1 : 1};
    Int3 face{signs.x > 0 ? 0 : 1, signs.y > 0 ? 2 : 3, signs.z > 0 ? 4 : 5};
    if (signs.x * signs.y * signs.z < 0) std::swap(face.y, face.z);
    const int tip = int(mesh.vertices.size());
    mesh.vertices.push_back(Vec3(signs) * float(point));
    for (int side = 0; side < 3; side++) mesh.triangles.push_back({face[side], face[(side + 1) % 3], tip});
  }
  return mesh;
}

/// Largest distance from a point divided by the smallest.
double unevenness(const TriMesh& mesh, Vec3d middle) {
  double low = 1e30, high = 0;
  for (const Vec3 x : mesh.vertices)
    low = std::min(low, norm(Vec3d(x) - middle)), high = std::max(high, norm(Vec3d(x) - middle));
  return high / low;
}

// A star becomes a ball of the same volume about its center.
TEST(Rounded, StarBecomesBallOfEqualVolume) {
  TriMesh mesh = star(1.2);
  EXPECT_GT(unevenness(mesh, {}), 2);
  const TriMesh round = rounded(mesh);
  EXPECT_NEAR(test::enclosed_volume(round) / test::enclosed_volume(mesh), 1, 0.03)
      << "the triangles are chords of the ball";
  EXPECT_LT(unevenness(round, {}), 1.001);

  const Vec3 center{0.3f, -0.1f, 0.25f};
  for (Vec3& x : mesh.vertices) x = x * 0.01f + center;
  EXPECT_LT(unevenness(rounded(mesh), Vec3d(center)), 1.001) << "at any position and size";
}

// An elongated shape keeps its aspect ratio in any orientation.
TEST(Rounded, ElongatedShapeKeepsAspectRatio) {
  TriMesh mesh = star(0.9);
  const Vec3 axis = normalized(Vec3{1, 2, -1});
  for (Vec3& x : mesh.vertices) x = x + axis * (2 * dot(x, axis));  // three times as long
  const TriMesh round = rounded(mesh);
  EXPECT_NEAR(test::enclosed_volume(round) / test::enclosed_volume(mesh), 1, 0.03);
  double most = 0, wide = 0;
  for (const Vec3 x : round.vertices) {
    most = std::max(most, std::abs(double(dot(x, axis))));
    wide = std::max(wide, double(norm(x - axis * dot(x, axis))));
  }
  EXPECT_NEAR(most / wide, 3, 0.05);
}

// An empty mesh stays empty.
TEST(Rounded, EmptyMeshStaysEmpty) { EXPECT_TRUE(rounded({}).vertices.empty()); }

}  // namespace
}  // namespace turgor

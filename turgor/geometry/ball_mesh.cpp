#include "turgor/geometry/ball_mesh.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace turgor {

namespace {

/// Splits every triangle into four at its edge midpoints, projected onto the unit sphere.
TriMesh halved(const TriMesh& mesh) {
  TriMesh fine;
  fine.vertices = mesh.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), int(fine.vertices.size()));
    if (is_new)
      fine.vertices.push_back(normalized(mesh.vertices[std::size_t(a)] + mesh.vertices[std::size_t(b)]));
    return at->second;
  };
  for (const auto [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Int3 t : {Int3{a, ab, ca}, Int3{ab, b, bc}, Int3{ca, bc, c}, Int3{ab, bc, ca}})
      fine.triangles.push_back(t);
  }
  return fine;
}

}  // namespace

TriMesh ball_mesh(double radius, int halvings) {
  TriMesh ball{
      .vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
      .normals = {},
      .scalars = {}};
  for (int n = 0; n < halvings; n++) ball = halved(ball);
  for (Vec3& x : ball.vertices) x *= Real(radius);
  return ball;
}

}  // namespace turgor

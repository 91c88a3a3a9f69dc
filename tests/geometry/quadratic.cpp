#include "turgor/geometry/quadratic.hpp"

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"

namespace turgor {
namespace {

SolidMesh block() { return tetrahedralize(hex_block({0.3, 0.2, 0.1}, {3, 2, 1})); }

// Every edge has one midpoint node, which all its elements share.
TEST(Quadratic, EdgesShareOneMidpointNode) {
  const SolidMesh linear = block(), mesh = with_middles(linear);
  EXPECT_EQ(mesh.vertices.size(), std::size_t(7 * 5 * 3)) << "the nodes of a grid with half the spacing";
  ASSERT_EQ(element_count(mesh), element_count(linear));
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const auto x = [&](int node) { return mesh.vertices[std::size_t(element(mesh, e)[std::size_t(node)])]; };
    for (int c = 0; c < 4; c++)
      EXPECT_EQ(element(mesh, e)[std::size_t(c)], element(linear, e)[std::size_t(c)]);
    for (const auto [a, b] : kTetEdges) EXPECT_LT(norm(x(node_between(a, b)) - (x(a) + x(b)) / 2), 1e-15);
  }
  EXPECT_NEAR(volume(mesh), volume(linear), 1e-15);
  EXPECT_EQ(face_neighbors(mesh), face_neighbors(linear));
}

// The eight linear subelements fill their element and have positive orientation.
TEST(Quadratic, EightSubelementsFillElement) {
  const SolidMesh mesh = with_middles(block()), subelements = linear_subdivision(mesh);
  ASSERT_EQ(element_count(subelements), 8 * element_count(mesh));
  for (std::size_t e = 0; e < element_count(subelements); e++)
    EXPECT_NEAR(volume(subelements, e), volume(mesh, e / 8) / 8, 1e-15);
  // Neighbors that disagreed on a face would each have it on the surface.
  EXPECT_EQ(surface(subelements).triangles.size(), surface(mesh).triangles.size());
}

// The surface has four outward triangles per face of the linear mesh.
TEST(Quadratic, SurfaceHasFourTrianglesPerFace) {
  const SolidSurface coarse = surface(block()), fine = surface(with_middles(block()));
  const SolidMesh mesh = with_middles(block());
  ASSERT_EQ(fine.triangles.size(), 4 * coarse.triangles.size());
  double volume_inside = 0;
  for (const Int3 t : fine.triangles) {
    const auto x = [&](int v) { return mesh.vertices[std::size_t(v)]; };
    volume_inside += dot(x(t.x), cross(x(t.y), x(t.z))) / 6;
  }
  EXPECT_NEAR(volume_inside, 0.3 * 0.2 * 0.1, 1e-15);
  for (std::size_t t = 0; t < fine.triangles.size(); t++) EXPECT_EQ(fine.element[t], coarse.element[t / 4]);
}

}  // namespace
}  // namespace turgor

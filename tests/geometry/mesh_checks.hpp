// Checks that every tetrahedral mesh must pass before it is used in a computation.
#pragma once

#include <array>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/surface_edges.hpp"

namespace turgor::test {

/// Vertices − edges + triangles of the surface: 2 for a ball, 0 for a torus.
inline int euler_characteristic(const SolidMesh& mesh) {
  const SolidSurface outer = surface(mesh);
  std::set<int> vertices;
  for (const Int3 t : outer.triangles) vertices.insert({t.x, t.y, t.z});
  return int(vertices.size()) - int(outer.triangles.size()) / 2;
}

/// The triangles at a vertex form one closed ring.
inline void expect_one_ring_a_vertex(const SolidSurface& outer) {
  std::map<int, std::map<int, int>> next;  // at each vertex: from neighbor to neighbor
  for (const Int3 t : outer.triangles)
    for (int c = 0; c < 3; c++) next[t[c]][t[(c + 1) % 3]] = t[(c + 2) % 3];
  for (const auto& [vertex, ring] : next) {
    std::size_t steps = 0;
    int at = ring.begin()->first;
    do {
      ASSERT_TRUE(ring.contains(at)) << "vertex " << vertex;
      at = ring.at(at), steps++;
    } while (at != ring.begin()->first && steps <= ring.size());
    ASSERT_EQ(steps, ring.size()) << "vertex " << vertex << " has several rings of triangles";
  }
}

/// Every face has at most two elements, every element has volume, and the surface is a closed manifold that
/// encloses exactly the elements' volume.
inline void expect_sound(const SolidMesh& mesh) {
  std::map<std::array<int, 3>, int> faces;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    ASSERT_GT(volume(mesh, e), 0) << "element " << e;
    for (const auto& corners : element_faces(mesh)) {
      std::array<int, 3> face;
      for (std::size_t c = 0; c < 3; c++) face[c] = element(mesh, e)[std::size_t(corners[c])];
      std::sort(face.begin(), face.end());
      ASSERT_LE(++faces[face], 2) << "element " << e;
    }
  }
  const SolidSurface outer = surface(mesh);
  double enclosed = 0;
  for (const auto [a, b, c] : outer.triangles)
    enclosed += orientation({}, mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)],
                            mesh.vertices[std::size_t(c)]) /
                6;
  ASSERT_NEAR(enclosed, volume(mesh), 1e-9 * volume(mesh));
  for_each_edge(sorted_edges(outer.triangles), [&](std::span<const EdgeUse> uses) {
    ASSERT_EQ(uses.size(), 2u) << uses[0].a << "-" << uses[0].b;
    ASSERT_NE(uses[0].forward, uses[1].forward) << uses[0].a << "-" << uses[0].b;
  });
  expect_one_ring_a_vertex(outer);
}

}  // namespace turgor::test

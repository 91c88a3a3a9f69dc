// Surfaces with known distances and shapes: a slab with an irregular triangulation on top, and a sphere.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "tests/geometry/shapes.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/models/rhombus/surface.hpp"

namespace turgor::rhombus::test {

/// Removes vertices without triangles.
inline Surface surface_of(const std::vector<Vec3d>& vertices, std::vector<Int3> triangles) {
  std::vector<int> number(vertices.size(), -1);
  std::vector<Vec3d> used;
  for (Int3& t : triangles)
    for (int corner = 0; corner < 3; corner++) {
      int& n = number[std::size_t(t[corner])];
      if (n < 0) n = int(used.size()), used.push_back(vertices[std::size_t(t[corner])]);
      t[corner] = n;
    }
  return *build_surface(std::move(used), std::move(triangles));
}

/// The top of a slab, centered above the origin at z = 0, has `cells` × `cells` squares of two triangles.
/// Inner vertices of the top are shifted by up to `uneven` of a cell; at `uneven` = 0.35 many angles are
/// obtuse.
inline Surface slab(double side, int cells, double uneven) {
  const SolidMesh block = hex_block({side, side, side / 8}, {cells, cells, 1});
  std::vector<Vec3d> vertices = block.vertices;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-uneven * side / cells, uneven * side / cells);
  for (Vec3d& x : vertices) {
    x -= Vec3d{side / 2, side / 2, side / 8};
    const double inner = side / 2 * (1 - 1e-9);
    const double dx = shift(random), dy = shift(random);
    if (x.z > -1e-9 && std::abs(x.x) < inner && std::abs(x.y) < inner) x += Vec3d{dx, dy, 0};
  }
  return surface_of(vertices, surface(block).triangles);
}

/// An icosphere about the origin.
inline Surface sphere(double radius, int times) {
  const TriMesh mesh = turgor::test::sphere_surface({}, radius, times);
  std::vector<Vec3d> vertices;
  for (const Vec3 x : mesh.vertices) vertices.push_back(normalized(Vec3d(x)) * radius);
  return *build_surface(std::move(vertices), mesh.triangles);
}

}  // namespace turgor::rhombus::test

// Closed surfaces with known answers.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor::test {

inline TriMesh surface_of(const SolidMesh& mesh) {
  TriMesh result;
  for (const Vec3d x : mesh.vertices) result.vertices.push_back(Vec3(x));
  result.triangles = surface(mesh).triangles;
  return result;
}

/// Volume that a closed surface encloses [m³].
inline double enclosed_volume(const TriMesh& mesh) {
  double sum = 0;
  for (const Int3 t : mesh.triangles) {
    const auto x = [&](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
    sum += dot(x(t.x), cross(x(t.y), x(t.z))) / 6;
  }
  return sum;
}

/// A box from the origin to `size`, two triangles per side.
inline TriMesh box_surface(Vec3d size) { return surface_of(hex_block(size, {1, 1, 1})); }

/// A block in [-1, 1] × [-1, 1] × [0, 1] with a notch from above (y) down to the origin, 60 degrees wide.
inline TriMesh notched_surface() {
  const Vec3 outline[7] = {{-1, -1, 0}, {1, -1, 0},        {1, 1, 0}, {0.57735f, 1, 0},
                           {0, 0, 0},   {-0.57735f, 1, 0}, {-1, 1, 0}};
  TriMesh mesh;
  for (const float z : {0.0f, 1.0f})
    for (const Vec3 p : outline) mesh.vertices.push_back({p.x, p.y, z});
  for (int i = 0; i < 7; i++) {
    const int next = (i + 1) % 7;
    mesh.triangles.push_back({i, next, next + 7});
    mesh.triangles.push_back({i, next + 7, i + 7});
  }
  for (int i = 5; i < 10; i++) {  // the whole outline is visible from the origin
    mesh.triangles.push_back({4, (i + 1) % 7, i % 7});
    mesh.triangles.push_back({4 + 7, i % 7 + 7, (i + 1) % 7 + 7});
  }
  return mesh;
}

/// A tube around a ring in the plane z = 0 that turns twice before it closes. `offset` moves the turns
/// outward and inward in alternation. The overlap of both turns is enclosed twice.
inline TriMesh coil_surface(double ring, double offset, double tube) {
  constexpr int kAlong = 96, kAround = 24;
  TriMesh mesh;
  for (int i = 0; i < kAlong; i++)
    for (int j = 0; j < kAround; j++) {
      const double u = 4 * std::numbers::pi * i / kAlong, v = 2 * std::numbers::pi * j / kAround;
      const double r = ring + offset * std::cos(u / 2) + tube * std::cos(v);
      mesh.vertices.push_back(Vec3(Vec3d{r * std::cos(u), r * std::sin(u), tube * std::sin(v)}));
      const int i2 = (i + 1) % kAlong, j2 = (j + 1) % kAround;
      mesh.triangles.push_back({i * kAround + j, i2 * kAround + j, i2 * kAround + j2});
      mesh.triangles.push_back({i * kAround + j, i2 * kAround + j2, i * kAround + j2});
    }
  return mesh;
}

/// A sphere: an icosahedron, subdivided `times` times.
inline TriMesh sphere_surface(Vec3d center, double radius, int times) {
  const double g = std::numbers::phi;
  std::vector<Vec3d> x{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Int3> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                              {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                              {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                              {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (; times > 0; times--) {
    std::map<std::array<int, 2>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)}, int(x.size()));
      if (is_new) x.push_back(x[std::size_t(a)] + x[std::size_t(b)]);
      return at->second;
    };
    std::vector<Int3> finer;
    for (const auto [a, b, c] : triangles) {
      for (Vec3d& p : x) p = normalized(p);
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const Int3 t : {Int3{a, ab, ca}, Int3{b, bc, ab}, Int3{c, ca, bc}, Int3{ab, bc, ca}})
        finer.push_back(t);
    }
    triangles = finer;
  }
  TriMesh mesh{.triangles = triangles};
  for (const Vec3d p : x) mesh.vertices.push_back(Vec3(center + normalized(p) * radius));
  return mesh;
}

}  // namespace turgor::test

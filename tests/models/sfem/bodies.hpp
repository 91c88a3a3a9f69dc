// Bodies for tests of sfem: blocks with fixed vertices and a distorted interior.
#pragma once

#include <cmath>
#include <functional>
#include <random>

#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

struct Case {
  int corners;
  Formulation formulation;
};
constexpr Case kCases[] = {{4, Formulation::kStandard},
                           {4, Formulation::kAveraged},
                           {8, Formulation::kStandard},
                           {8, Formulation::kAveraged},
                           {10, Formulation::kStandard}};

/// Converts a block of hexahedra into elements with another number of nodes.
inline SolidMesh with_corners(const SolidMesh& hexahedra, int corners) {
  if (corners == 8) return hexahedra;
  return corners == 4 ? tetrahedralize(hexahedra) : with_middles(tetrahedralize(hexahedra));
}

inline bool on_box(Vec3d x, Vec3d size) {
  for (int axis = 0; axis < 3; axis++)
    if (x[axis] < 1e-9 * size[axis] || x[axis] > (1 - 1e-9) * size[axis]) return true;
  return false;
}

/// Shifts the vertices inside a block by up to `most` [m], reproducibly.
inline void distort(SolidMesh& mesh, Vec3d size, double most) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-most, most);
  for (Vec3d& x : mesh.vertices)
    if (!on_box(x, size)) x += Vec3d{shift(random), shift(random), shift(random)};
}

inline Body block_of(SolidMesh mesh, const Material& material, const std::function<bool(Vec3d)>& is_fixed) {
  Body body{.mesh = std::move(mesh), .materials = {material}};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(is_fixed(x));
  return body;
}

/// The vertex nearest to a point.
inline int vertex_at(const SolidMesh& mesh, Vec3d x) {
  int best = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); v++)
    if (norm(mesh.vertices[v] - x) < norm(mesh.vertices[std::size_t(best)] - x)) best = int(v);
  return best;
}

/// The plate of the paper: 0.1 × 0.1 × 0.01 m, clamped at its four sides.
inline Body clamped_plate(int n, int layers) {
  return block_of(hex_block({0.1, 0.1, 0.01}, {n, n, layers}), {1e5, 0.4},
                  [](Vec3d x) { return x.x < 1e-9 || x.y < 1e-9 || x.x > 0.1 - 1e-9 || x.y > 0.1 - 1e-9; });
}

}  // namespace turgor::sfem

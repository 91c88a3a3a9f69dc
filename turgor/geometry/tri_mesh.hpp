// Triangle mesh for drawing, files and contact. Normals and scalars are optional: empty, or one per vertex.
#pragma once

#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

struct TriMesh {
  std::vector<Vec3> vertices;   // [m]
  std::vector<Int3> triangles;  // counter-clockwise seen from outside
  std::vector<Vec3> normals;    // unit, outward
  std::vector<float> scalars;   // a quantity shown as color
};

/// Area-weighted vertex normals.
inline std::vector<Vec3> vertex_normals(const TriMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size());
  for (const auto [a, b, c] : mesh.triangles) {
    const auto& x = mesh.vertices;
    const Vec3 n = cross(x[std::size_t(b)] - x[std::size_t(a)], x[std::size_t(c)] - x[std::size_t(a)]);
    for (const int corner : {a, b, c}) normals[std::size_t(corner)] += n;
  }
  for (Vec3& n : normals) n = normalized(n);
  return normals;
}

}  // namespace turgor

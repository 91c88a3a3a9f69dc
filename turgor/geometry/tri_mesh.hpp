// Triangle mesh for drawing, files and contact. Normals and scalars are optional: empty, or one per vertex.
#pragma once

#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

struct TriMesh {
  std::vector<Vec3> vertices;   // [m]
  std::vector<Int3> triangles;  // counter-clockwise seen from outside
  std::vector<Vec3> normals;    // unit, outward
  std::vector<float> scalars;   // a quantity shown as color
};

/// Mesh of vertices in double precision, without normals.
inline TriMesh mesh_of(std::span<const Vec3d> vertices, std::span<const Int3> triangles) {
  TriMesh mesh{.triangles = {triangles.begin(), triangles.end()}};
  for (const Vec3d x : vertices) mesh.vertices.push_back(Vec3(x));
  return mesh;
}

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

// A volume mesh of tetrahedra or hexahedra, and what is known about it without any physics: volumes, the
// surface, connected parts. How meshes are made is in hex_block.hpp and stuffing.hpp; how they are read in
// io/mesh/solid_files.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

/// Elements of one kind, each `corners` vertices in VTK's order: a tetrahedron's last corner is on the side
/// that its first three face counter-clockwise; a hexahedron's corners are bottom face, then top face, both
/// counter-clockwise seen from above. A quadratic tetrahedron's nodes are its corners, then the middles of
/// its edges (quadratic.hpp).
struct SolidMesh {
  std::vector<Vec3d> vertices;  // [m]
  int corners = 4;              // 4: tetrahedra, 8: hexahedra, 10: quadratic tetrahedra
  std::vector<int> elements;    // `corners` vertices each
  std::vector<int> regions;     // a number an element, from a file or a segmentation; empty = all are 0
};

inline std::size_t element_count(const SolidMesh& mesh) {
  return mesh.elements.size() / std::size_t(mesh.corners);
}
inline std::span<const int> element(const SolidMesh& mesh, std::size_t e) {
  return {mesh.elements.data() + e * std::size_t(mesh.corners), std::size_t(mesh.corners)};
}
inline int region(const SolidMesh& mesh, std::size_t e) { return mesh.regions.empty() ? 0 : mesh.regions[e]; }

/// Six times the signed volume of a tetrahedron: positive when its corners are in the order above.
inline double orientation(Vec3d a, Vec3d b, Vec3d c, Vec3d d) { return dot(cross(b - a, c - a), d - a); }

/// Signed volume of an element [m³]; of a hexahedron, that of its trilinear map, of a quadratic tetrahedron,
/// that of its quadratic one.
double volume(const SolidMesh& mesh, std::size_t e);
double volume(const SolidMesh& mesh);
Vec3d centroid(const SolidMesh& mesh, std::size_t e);

/// The outer surface, quadrilaterals split in two and faces of quadratic tetrahedra in four,
/// counter-clockwise seen from outside.
struct SolidSurface {
  std::vector<Int3> triangles;  // vertices of the solid mesh
  std::vector<int> element;     // behind each triangle
};
SolidSurface surface(const SolidMesh& mesh);

/// The element across every face of every element, -1 outside: 4 a tetrahedron, 6 a hexahedron, in the order
/// of element_faces.
std::vector<int> face_neighbors(const SolidMesh& mesh);
/// Corners of each face of an element, counter-clockwise seen from outside; the fourth is -1 for triangles.
std::span<const std::array<int, 4>> element_faces(const SolidMesh& mesh);

/// The connected part (elements that share a face, numbered by size, largest first) of every element.
std::vector<int> connected_parts(const SolidMesh& mesh);

}  // namespace turgor

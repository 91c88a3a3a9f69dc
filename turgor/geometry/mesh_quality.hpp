// How well-shaped the tetrahedra of a mesh are: dihedral angles, edge lengths, volumes. Flat or needle-like
// elements make stiffness matrices ill-conditioned; that is why a mesh says its worst angles before it is
// used.
#pragma once

#include <array>
#include <cstddef>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

struct MeshQuality {
  double min_dihedral = 0, max_dihedral = 0;         // [degrees]
  double shortest_edge = 0, longest_edge = 0;        // [m]
  double smallest_volume = 0;                        // signed, of an element [m³]
  double volume = 0;                                 // of all elements [m³]
  std::array<std::size_t, 18> dihedral_histogram{};  // how many angles in each ten degrees
};

/// Of a mesh of tetrahedra; all zero when it has none.
MeshQuality measure_quality(const SolidMesh& mesh);

/// The six angles between the faces of a tetrahedron, at the edges 01 02 03 12 13 23 [degrees].
std::array<double, 6> dihedral_angles(const std::array<Vec3d, 4>& x);

}  // namespace turgor

// Quality of tetrahedral meshes: dihedral angles, edge lengths, volumes. Flat or needle-like elements make
// stiffness matrices ill-conditioned.
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
  std::array<std::size_t, 18> dihedral_histogram{};  // number of angles in each ten degrees
};

/// Quality of a tetrahedral mesh; all zero if it has no elements.
MeshQuality measure_quality(const SolidMesh& mesh);

/// Six dihedral angles of a tetrahedron, at the edges 01 02 03 12 13 23 [degrees].
std::array<double, 6> dihedral_angles(const std::array<Vec3d, 4>& x);

}  // namespace turgor

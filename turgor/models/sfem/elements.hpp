// Stiffness of one element, and the assembly of many. Linear tetrahedra; trilinear hexahedra with 2×2×2 Gauss
// points; their averaged forms for nearly incompressible tissue.
#pragma once

#include <span>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// 12×12, row by row, unknowns x0 y0 z0 x1 … [N/m].
void tet_stiffness(const std::array<Vec3d, 4>& x, const Material& material, std::span<double, 144> k);
/// 24×24, row by row [N/m].
void hex_stiffness(const std::array<Vec3d, 8>& x, const Material& material, Formulation formulation,
                   std::span<double, 576> k);

/// The material of every element of a body: its own, or that of the last inclusion its centroid is in.
std::vector<int> element_materials(const Body& body);

/// K over all nodes of a mesh, row i = vertex i; `material` is an index into `materials` for every element.
BlockMatrix assemble(const Exec& exec, const SolidMesh& mesh, std::span<const Material> materials,
                     std::span<const int> material, Formulation formulation);

}  // namespace turgor::sfem

// Stiffness of one element, and the assembly of many. Linear tetrahedra; trilinear hexahedra with 2×2×2 Gauss
// points; their averaged forms for nearly incompressible tissue, in which the change of volume is measured as
// a mean, over the element [Hughes 1980, B-bar] or around each node [Bonet, Burton 1998]. Quadratic
// tetrahedra with four Gauss points, which are exact where their edges are straight.
#pragma once

#include <array>
#include <span>

#include "turgor/core/assert.hpp"
#include "turgor/models/sfem/lists.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Bulk and shear modulus.
struct Moduli {
  double bulk = 0, shear = 0;  // [Pa]
};
inline Moduli moduli(const Material& m) {
  TURGOR_CHECK(m.poisson > -1 && m.poisson < 0.5, "Poisson's ratio is between -1 and 0.5");
  return {m.young / (3 * (1 - 2 * m.poisson)), m.young / (2 * (1 + m.poisson))};
}

/// 12×12, row by row, unknowns x0 y0 z0 x1 … [N/m].
void tet_stiffness(const std::array<Vec3d, 4>& x, Moduli moduli, std::span<double, 144> k);
inline void tet_stiffness(const std::array<Vec3d, 4>& x, const Material& material, std::span<double, 144> k) {
  tet_stiffness(x, moduli(material), k);
}
/// 24×24, row by row [N/m].
void hex_stiffness(const std::array<Vec3d, 8>& x, const Material& material, Formulation formulation,
                   std::span<double, 576> k);
/// 30×30, row by row [N/m].
void quadratic_stiffness(const std::array<Vec3d, 10>& x, const Material& material, std::span<double, 900> k);
/// The smallest determinant of a hexahedron's map at its Gauss points, times 8 [m³]: its volume if it is a
/// box, not positive if it cannot be an element.
double least_hex_volume(const std::array<Vec3d, 8>& x);
/// The same of a quadratic tetrahedron, by a sixth: its volume if its edges are straight.
double least_quadratic_volume(const std::array<Vec3d, 10>& x);

/// Appends the Gauss points of an element of 4, 8 or 10 nodes: gradients of its functions, three numbers a
/// node [1/m], and the volume that each point stands for [m³].
void append_gauss_points(std::span<const Vec3d> x, std::vector<double>& gradient,
                         std::vector<double>& volume);

/// The quadratic functions of a tetrahedron's ten nodes where its linear ones have these values.
std::array<double, 10> quadratic_weights(const std::array<double, 4>& linear);

/// True when the change of volume is averaged around nodes.
inline bool averages_nodes(const SolidMesh& mesh, Formulation formulation) {
  return mesh.corners == 4 && formulation == Formulation::kAveraged;
}

/// The vertices of every element.
Lists element_lists(const SolidMesh& mesh);

/// The material of every element of a body: its own, or that of the last inclusion its centroid is in.
std::vector<int> element_materials(const Body& body);

/// The tetrahedra of one material around each vertex: u changes their volume (a quarter of it) by
/// Σ gradient·u, and that costs ½ bulk/volume (Σ gradient·u)².
struct NodalVolumes {
  Lists vertices;               // around each, ascending
  std::vector<Vec3d> gradient;  // for each of `vertices.item` [m²]
  std::vector<double> volume;   // [m³]
  std::vector<int> material;
  std::vector<int> center;  // the vertex
};
NodalVolumes nodal_volumes(const SolidMesh& mesh, std::span<const int> material);

/// The stiffness matrices of all elements, one behind the other; those of averaged tetrahedra resist shear
/// only, because their volumes are not their own.
std::vector<double> element_matrices(const Exec& exec, const SolidMesh& mesh,
                                     std::span<const Material> materials, std::span<const int> material,
                                     Formulation formulation);

/// K over all nodes of a mesh, row i = vertex i; `material` is an index into `materials` for every element.
BlockMatrix assemble(const Exec& exec, const SolidMesh& mesh, std::span<const Material> materials,
                     std::span<const int> material, Formulation formulation);

}  // namespace turgor::sfem

// Bending of a sheet, independent of its triangulation. The curvature tensor H_i at a vertex is the area
// average of the folds of its edges, and the energy is
//
//   E = Σ_i ½ A_i H_i : B H_i,     H_i = 1/A_i Σ_{e∋i} ½ |e| J_e n_e n_eᵀ
//
// with A_i the vertex area, B the rigidities, J_e the change of slope across edge e and n_e its in-plane
// normal. With rest triangles unrolled into the plane, J_e is a constant linear form of four positions. So E
// is quadratic, and its weights never change [isometric bending: Bergou et al. 2006]. Where all edges of a
// vertex bend, A_i is a tensor, so that H_i of a constant curvature is that curvature:
//
//   A_i = Σ_{e∋i} ½ |e| n_e n_eᵀ ⊗ ∂J_e/∂κ
#pragma once

#include <span>
#include <vector>

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

struct Fabric;

/// Weights of all vertex pairs that bending couples, in Spring::bend: the force on i is Σ_j w_ij (x_j − x_i)
/// [N/m]. Pairs farther apart have negative weights. `is_sliver`: of each triangle (slivers.hpp).
std::vector<Spring> bending_weights(const TriMesh& mesh, const Fabric& fabric,
                                    std::span<const char> is_sliver);

/// Diagonal per vertex that Jacobi's method needs beyond the sum of its row [N/m]. Rows with entries of both
/// signs are not diagonally dominant; half of the deficit is enough.
std::vector<double> missing_diagonal(const std::vector<Spring>& springs, int count);

}  // namespace turgor::cloth

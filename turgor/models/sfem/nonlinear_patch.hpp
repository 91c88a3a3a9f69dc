// A patch whose fine elements follow a nonlinear law, in a body that is linear outside of it. The exterior is
// condensed to the coarse vertices on the patch's border, a constant spring from the Green's functions:
//
//   E(u) = Σ V Ψ(F(u)) + ½ uᵀ S u − f·u        S = Ξ_tt⁻¹ − K_P on the border, Ψ of law.hpp
//
// with t the coarse vertices of the patch and K_P the linear stiffness of its coarse elements. Newton steps
// with line search solve it for the forces of the latest tick. Ticks use the linearization at that solution,
// u = u₀ + C (f − f₀), as an ordinary patch with a shift u₀ − C f₀.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/models/sfem/law.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::sfem {

/// A number of an unknown node and its weight in the displacement of a dependent one.
struct WeightedNode {
  int node = 0;
  double weight = 1;
};

/// Constant data and the present solution of a nonlinear patch.
struct NonlinearPatch {
  Law law;
  Patch patch;                         // points, triangles and coarse vertices; no compliance
  std::vector<WeightedNode> weighted;  // of all fine nodes, one after the other
  std::vector<std::size_t> begin;      // fine nodes + 1: the first of each in `weighted`; none = fixed
  std::vector<int> corners;            // fine elements, of `element_nodes` fine nodes each
  int element_nodes = 0;
  std::vector<Moduli> moduli;                    // of each element
  std::vector<double> gradient, volume;          // Gauss points of all elements (append_gauss_points)
  std::vector<std::uint8_t> at_border;           // 1 for elements beside the border
  std::vector<std::vector<WeightedNode>> point;  // unknown nodes of each point of the patch
  std::vector<int> coarse_node;                  // unknown node of each of Patch::coarse
  std::vector<int> rim;                          // indices into Patch::coarse: vertices on the border
  std::vector<double> exterior;                  // S, 3·rim square, column-major [N/m]
  std::vector<double> coarse_stiffness;          // Ξ_tt⁻¹, 3·coarse square, column-major [N/m]
  std::vector<double> lifted;                    // stiffness at rest, as `tangent.value`: regularizes a step
  BlockMatrix tangent;                           // of the unknown nodes
  Elimination plan;
  std::vector<double> u;     // displacement of the unknown nodes, three each [m]
  double largest_force = 0;  // norm of the forces on all points, the largest so far [N]
};

/// Cost and result of a solution.
struct NonlinearReport {
  int steps = 0;             // Newton steps
  double residual = 0;       // norm of the forces that were not balanced before the last step [N]
  bool converged = false;    // that is below a hundredth of the largest forces so far
  double strain = 0;         // largest Green strain in the patch [1]
  double border_strain = 0;  // the same in elements beside the border, where the body is linear [1]
};

/// Nonlinear patch at rest over the elements of a linear one, with the same points. Requires the columns of
/// all vertices of the elements. Error: node-averaged or B-bar elements, or a body that moves by its inertia.
Result<NonlinearPatch> make_nonlinear_patch(const Model& model, const Patch& linear, int refinement,
                                            const Law& law);

/// Solves the equilibrium under forces on the points, three numbers each [N], from the present displacement,
/// and returns the patch linearized there. Error: the tangent is not positive definite at any regularization.
Result<Patch> solve_nonlinear(NonlinearPatch& patch, std::span<const double> forces, int most_steps,
                              NonlinearReport* report = nullptr);

/// Displacements of the points [m].
std::vector<Vec3d> point_displacements(const NonlinearPatch& patch);

}  // namespace turgor::sfem

// Finite element organs pressed by balls at several points, shared by the experiments on element types,
// patches and the expected error. The reference solution is finer everywhere.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor {

/// A mesh of linear tetrahedra, its support direction, and the ball that presses it.
struct PressedOrgan {
  std::string name;
  SolidMesh mesh;
  Vec3d down;                               // towards the support
  double radius = 0, depth = 0, patch = 0;  // of the ball, of its press, of the patch [m]
};

/// Approximate tongue of 60 mm: an ellipsoid that is thicker at one end. `edge`: edge length of its
/// tetrahedra [m].
Result<PressedOrgan> pressed_tongue(const Exec& exec, double edge);
/// Liver of the phantom.
Result<PressedOrgan> pressed_liver(const Exec& exec, double edge);
/// Block of 80 × 80 × 40 mm; each cell is cut into six tetrahedra.
PressedOrgan pressed_tet_block(double cell);

/// Element type, and its refinement below the ball.
struct ElementChoice {
  std::string name;
  bool quadratic = false;
  sfem::Formulation formulation = sfem::Formulation::kStandard;
  int refinement = 1;    // of the patch
  bool cut_all = false;  // every tetrahedron of the body cut in eight
  double reach = 1;      // radius of the patch, relative to the organ's [1]
};
/// Contact point of a ball: the centroid of a triangle, and its normal.
struct PressPoint {
  Vec3d x, normal;
};
/// The highest triangles above three fixed points.
std::vector<PressPoint> press_points(const PressedOrgan& organ);

/// Forces of the presses, and the cost of the precomputation.
struct OrganForces {
  std::vector<double> force;  // at each press point [N]
  double expected_error = 0;  // relative error expected by the report [1]
  int nodes = 0;              // free nodes
  sfem::GreenCost cost;
};
/// Approximate number of operations of the presses, before anything is built. Nearly all of them factorize
/// the dense systems of the patches.
double press_flops(const PressedOrgan& organ, const ElementChoice& choice);
Result<OrganForces> press_organ(const Exec& exec, const PressedOrgan& organ, const ElementChoice& choice,
                                double poisson);

}  // namespace turgor

// Organs of finite elements that balls are pressed into at several places: what experiments on kinds of
// elements, on patches and on the error to be expected have in common. A reference is finer all over.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor {

/// A mesh of linear tetrahedra, which way it is held, and the ball that presses it.
struct PressedOrgan {
  std::string name;
  SolidMesh mesh;
  Vec3d down;                               // to what holds it
  double radius = 0, depth = 0, patch = 0;  // of the ball, of its press, of the patch [m]
};

/// About a tongue of 60 mm: an ellipsoid that is thicker at one end. `edge` of its tetrahedra [m].
Result<PressedOrgan> pressed_tongue(const Exec& exec, double edge);
/// The phantom's liver.
Result<PressedOrgan> pressed_liver(const Exec& exec, double edge);
/// 80 × 80 × 40 mm, cells cut into six tetrahedra each.
PressedOrgan pressed_tet_block(double cell);

/// Elements, and how finely they are cut where the ball is.
struct ElementsWay {
  std::string name;
  bool quadratic = false;
  sfem::Formulation formulation = sfem::Formulation::kStandard;
  int refinement = 1;    // of the patch
  bool cut_all = false;  // every tetrahedron in eight, all over
  double reach = 1;      // of the patch, in parts of the organ's
};
/// Where a ball comes down: the middle of a triangle, and its normal.
struct PressedPlace {
  Vec3d x, normal;
};
/// The triangles that lie highest above three places.
std::vector<PressedPlace> places_on(const PressedOrgan& organ);

/// What presses answer, and what they cost beforehand.
struct OrganForces {
  std::vector<double> force;  // of each place [N]
  double said = 0;            // how far off the report says that they may be [1]
  int nodes = 0;              // free ones
  sfem::GreenCost cost;
};
/// About how many operations its presses take, known before anything is built: nearly all of them factor the
/// dense systems of the patches.
double press_flops(const PressedOrgan& organ, const ElementsWay& way);
Result<OrganForces> press_organ(const Exec& exec, const PressedOrgan& organ, const ElementsWay& way,
                                double poisson);

}  // namespace turgor

// Expected error of a round tool's force by the finite size of the elements, for reports. Fitted to presses
// of balls on organs, compared with globally refined meshes (docs/validation.md). It is an estimate from
// above, not a bound.
#pragma once

#include <span>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Root of the mean square of these elements' edges [m].
double mean_edge(const SolidMesh& mesh, std::span<const int> elements);

/// Element sizes and the contact.
struct TouchedElements {
  int corners = 4;  // of an element: 4, 8 or 10
  Formulation formulation = Formulation::kStandard;
  double poisson = 0.45;  // [1]
  double edge = 0;        // [m]
  int refinement = 1;     // subdivisions of an edge in the patch
  double patch = 0.02;    // its radius [m]
  double contact = 0;     // contact radius: √(tool radius · depth) [m]
};
/// Elements of a patch with this refinement and radius [m], under a contact of this radius [m]. The material
/// is that of the first element.
TouchedElements touched_elements(const Model& model, std::span<const int> elements, int refinement,
                                 double patch, double contact);
/// Largest relative error that has a meaning: above, the force is unknown. The estimate is a power of the
/// edge relative to the contact, and tiny contacts would give thousands of millions of percent.
constexpr double kForceUnknown = 1;
/// Relative error of the force [1].
double expected_error(const TouchedElements& touched);

}  // namespace turgor::sfem

// How far the force of a round tool is off because elements are as large as they are: what a report says of
// it before anybody refines a mesh. Fitted to presses of balls on organs against meshes refined all over
// (docs/validation.md); an estimate from above, not a bound.
#pragma once

#include <span>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Root of the mean square of these elements' edges [m].
double mean_edge(const SolidMesh& mesh, std::span<const int> elements);

/// Elements and what touches them.
struct TouchedElements {
  int corners = 4;  // of an element: 4, 8 or 10
  Formulation formulation = Formulation::kStandard;
  double poisson = 0.45;  // [1]
  double edge = 0;        // [m]
  int refinement = 1;     // parts that a patch cuts an edge into
  double patch = 0.02;    // its radius [m]
  double contact = 0;     // radius of what the tool covers: √(its radius · its depth) [m]
};
/// Of the force, relative [1].
double expected_error(const TouchedElements& touched);

}  // namespace turgor::sfem

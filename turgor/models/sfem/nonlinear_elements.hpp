// Energy, internal forces and tangent of a nonlinear patch at its present displacement.
#pragma once

#include <vector>

#include "turgor/models/sfem/nonlinear_patch.hpp"

namespace turgor::sfem {

/// Fills NonlinearPatch::tangent, and `forces` with the internal forces on the unknown nodes [N] unless it is
/// null. Returns the strains.
NonlinearReport assemble_nonlinear(NonlinearPatch& patch, std::vector<double>* forces);

/// E(u) = Σ V Ψ + ½ uᵀ S u − f·u at the present displacement [J]; infinite where an element is nearly
/// inverted.
double nonlinear_energy(const NonlinearPatch& patch, const std::vector<double>& f);

}  // namespace turgor::sfem

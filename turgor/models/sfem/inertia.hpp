// Mass of a body that no vertex holds. Implicit Euler adds M/h² to its stiffness, so that K + M/h² has an
// inverse, and Green's functions are those of one frame of h seconds. M is lumped: it acts on the
// displacement of single vertices, also within a patch, whose fine functions vanish there.
#pragma once

#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Mass of every vertex [kg]: an equal share of each linear element; of quadratic tetrahedra 1/36 for each
/// corner and 4/27 for each midside node. [Hinton, Rock, Zienkiewicz 1976]
std::vector<double> lumped_masses(const SolidMesh& mesh, double density);

/// Adds M/h² to the diagonal of K; needs Model::mass.
void add_inertia(Model& model);

}  // namespace turgor::sfem

// Contacts in the coarse operator. Their stiffness is Σ Wᵀ M W over the contacts, with the displacement W u
// of the point of each and its stiffness M. Coarse displacements are nearly affine in a small patch of
// contacts, so that the stiffness of a patch is projected to its twelve affine displacements Φ, in the scalar
// product of M:
//   U Uᵀ,   U = Wᵀ M Φ (Φᵀ M Φ)^(−1/2)
// It is never larger than that of the contacts. These columns join those of stitches (coupled_points.hpp).
// Without them, corrections under a tool are too long, and their step lengths fall to a twentieth.
#pragma once

#include "turgor/models/lattice/coarse/point_columns.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"

namespace turgor::lattice {

/// Columns of the contacts of a body at the present displacements, with a stiffness of 1 N/m each.
struct ContactColumns {
  PointColumns columns;              // U [√(N/m)]
  std::vector<double> displacement;  // Uᵀ A⁻¹ U, row by row [1]
  std::vector<double> of_couplings;  // Vᵀ A⁻¹ U of the couplings V, row by row
};

/// Columns of the contacts that push or hold. Contacts far from each other form patches, 16 at most.
ContactColumns find_contact_columns(const Model& model, State& state, const Inputs& inputs);

/// Forces of the contacts at the present displacements, in the order of Inputs::contacts.
std::vector<ContactForce> contact_forces(const Model& model, State& state, const Inputs& inputs);

}  // namespace turgor::lattice

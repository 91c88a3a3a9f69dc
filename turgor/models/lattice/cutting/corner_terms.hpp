// Displacement of a corner as a mean over few tissue nodes, for surfaces that are drawn many times between
// two cuts. The terms depend only on the cuts.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Term of the mean: the displacement of a tissue node, or its extrapolation by one more `offset` from the
/// node behind it (extrapolate.hpp).
struct CornerTerm {
  int near = 0, far = -1;  // slots; −1: not extrapolated
  Vec3 offset;             // from `near` to the corner, along the axes of the lattice [m]
};

/// Appends the terms of a corner (Fragment::corner): those of extrapolate_from_neighbors for an air node, one
/// for tissue. Appends none for virtual nodes and for air two cells away from tissue.
void add_corner_terms(const Model& model, const Cuts& cuts, int corner, std::vector<CornerTerm>& terms);
/// Mean of at least one term [m]; the same bits as corner_displacement.
Vec3 mean_of_terms(std::span<const CornerTerm> terms, const VecField& u);

}  // namespace turgor::lattice

// Shares of the fragments of a cut cell: in its volume, in a patch and in a triangle of its skin.
#pragma once

#include <vector>

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Volume fractions of the fragments of a cut cell. They are measured along the axis with most crossings
/// between fragments.
struct Shares {
  std::vector<Real> of;       // by fragment: fraction of the cell's volume
  std::vector<Real> parted;   // by fragment: fraction of its volume in its own element
  std::vector<Real> bridges;  // by crack tip: fraction of both fragments' volume in the bridge element
};
Shares shares_of(const Fragments& fragments, const Cuts& cuts, const CutCell& cell);

/// Fraction of the area of a patch in each fragment of its cell: of sample points in its plane in the cell.
std::vector<Real> patch_shares(const Model& model, const Cuts& cuts, const Fragments& fragments,
                               const CutCell& cell, const SkinPatch& patch);

/// Number of sample points of a skin triangle in each fragment of its cell.
std::vector<int> count_points(const Fragments& fragments, const Cuts& cuts, const CutCell& cell,
                              const Vec3 (&corner)[3], int subdivisions);

}  // namespace turgor::lattice

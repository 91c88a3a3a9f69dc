// A straight cut in a block of tense skin on solid tissue by finite elements of its own: one mesh that fits
// the blade, its nodes doubled there, Newton's method. Nothing of the lattice is in it but the two laws.
#pragma once

namespace turgor {

/// A cut in the middle of a block's skin, the block held at its sides and below.
struct CutBlock {
  double side = 0, height = 0;                   // [m]
  double length = 0, depth = 0;                  // of the cut [m]
  double young = 0, poisson = 0;                 // of the tissue [Pa] [1]
  double tension = 0, stiffness = 0, shear = 0;  // of the skin, alike along and across [N/m]
  double amplification = 0;                      // of the skin [1]
};

/// How far its lips are apart in the middle of the cut [m]: trilinear elements on a quarter of the block,
/// about `parts` across half a cut, denser at its edges.
double gape_of_elements(const CutBlock& block, int parts);

}  // namespace turgor

// A straight cut in a block of tense skin on solid tissue, by an independent finite element solution. One
// mesh fits the blade, with doubled nodes on it; Newton's method solves it. It shares only the two material
// laws with the lattice.
#pragma once

namespace turgor {

/// A cut in the middle of a block's skin; the block is fixed at its sides and below.
struct CutBlock {
  double side = 0, height = 0;                   // [m]
  double length = 0, depth = 0;                  // of the cut [m]
  double young = 0, poisson = 0;                 // of the tissue [Pa] [1]
  double tension = 0, stiffness = 0, shear = 0;  // of the skin, equal along and across [N/m]
  double amplification = 0;                      // of the skin [1]
};

/// Distance of the lips in the middle of the cut [m]. Uses trilinear elements on a quarter of the block,
/// about `parts` across half a cut, denser at its edges.
double gape_of_elements(const CutBlock& block, int divisions);

}  // namespace turgor

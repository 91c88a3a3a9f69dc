// Closing force of a lens that a square membrane under tension loses, by an independent finite element
// solution. Its mesh fits the lens; Newton's method solves it. It shares only the energy of the skin with the
// lattice: equal fibers along and across, large displacements, no tissue, no bulging.
#pragma once

namespace turgor {

/// A membrane that is held at its sides, and its stitches. They hold skin at a distance from the lips as if
/// these met.
struct LensMembrane {
  double side = 0;       // of the membrane [m]
  double length = 0;     // of the lens [m]
  double width = 0;      // of the lens, whose lips are arcs of circles [m]
  double tension = 0;    // equal along and across [N/m]
  double stiffness = 0;  // equal along and across; that of shear is half of it [N/m]
  int stitches = 0;      // an even number, in the middles of equal parts of the length
  double bite = 0;       // from the lip [m]
  double patch = 0;      // half the side of the skin on which a stitch acts, with linear weights [m]
  bool pushes = false;   // a bond instead of threads, which are slack near the ends
};

/// Sum of the forces of all stitches across the lens [N]; NaN if Newton's method did not converge. Uses about
/// `divisions` elements over half the length, finer at its end.
double closing_force_of_elements(const LensMembrane& membrane, int divisions);

}  // namespace turgor

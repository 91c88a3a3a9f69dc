// A cut in tense skin on tissue of any height and along any curve, by an independent linear finite element
// solution: linear elasticity below a membrane with initial tension, on one mesh that fits blade and skin. It
// holds for small tensions, where every law is linear, and shares no source with the lattice.
#pragma once

#include <functional>

namespace turgor {

/// A body below the graph z = height(x, y), with vertical columns of equal thickness; fixed at its sides and
/// bottom. A blade follows the curve y = curve(x) for |x| < half_length, vertically down.
struct CurvedWound {
  std::function<double(double, double)> height;  // of the skin [m]
  std::function<double(double)> curve;           // of the blade; also beyond its ends [m]
  double half_x = 0, half_y = 0, thickness = 0;  // [m]
  double half_length = 0, depth = 0;             // of the cut [m]
  double young = 0, poisson = 0;                 // of the tissue [Pa] [1]
  double tension = 0;                            // of the skin, equal in all directions [N/m]
  double stiffness = 0, shear = 0;  // of fibers along and across the x axis under that tension [N/m]
};

/// Distance of the lips across the curve, at the skin [m].
struct Gape {
  double largest = 0, middle = 0;
};

/// Gape with about `divisions` elements along half a cut, denser at its ends.
Gape gape_of_linear_elements(const CurvedWound& wound, int divisions);
/// Gape extrapolated to elements of no size, from meshes with these divisions; the error is of first order.
Gape limit_of_linear_elements(const CurvedWound& wound, int coarse, int fine);

}  // namespace turgor

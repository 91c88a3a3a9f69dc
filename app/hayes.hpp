// A rigid indenter without friction on an elastic layer that is bonded to a rigid base. Solves the integral
// equation of Hayes, Keer, Herrmann, Mockros (J. Biomechanics 5, 1972) numerically, independent of any mesh.
#pragma once

#include "turgor/models/sfem/sfem.hpp"

namespace turgor {

struct BondedLayer {
  double thickness = 0;  // [m]
  sfem::Material material;
};

struct Indentation {
  double depth = 0;  // [m]
  double force = 0;  // [N]
};

/// Force of a flat punch of this radius, pressed in by `depth`.
Indentation hayes_punch(const BondedLayer& layer, double radius, double depth);
/// Depth and force of a sphere, pressed in until its contact has this radius.
Indentation hayes_sphere(const BondedLayer& layer, double sphere_radius, double contact_radius);

}  // namespace turgor

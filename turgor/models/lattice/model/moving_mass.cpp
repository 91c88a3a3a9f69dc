#include "turgor/models/lattice/model/moving_mass.hpp"

namespace turgor::lattice {

double moving_mass(const Anatomy& anatomy) {
  double mass = 0;
  for (const Real w : anatomy.inverse_mass)
    if (w > 0) mass += 1 / double(w);
  return mass;
}

}  // namespace turgor::lattice

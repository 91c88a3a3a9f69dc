#include "turgor/sim/report/gape_error.hpp"

#include <algorithm>

namespace turgor {

double expected_gape_error_of_partial_cells(const lattice::Anatomy& anatomy, double length, double depth) {
  constexpr double kFactor = 0.35, kLeast = 0.04;        // [1]
  constexpr double kLeastLength = 6, kLeastDepth = 1.6;  // [spacings]
  const Vec3 h = anatomy.lattice.spacing;
  const double spacing = double(std::max({h.x, h.y, h.z}));
  if (!(length >= kLeastLength * spacing) || !(depth >= kLeastDepth * spacing)) return -1;
  return std::max(kLeast, kFactor * spacing / length);
}

}  // namespace turgor

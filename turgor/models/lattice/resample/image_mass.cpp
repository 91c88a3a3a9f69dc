#include "turgor/models/lattice/resample/image_mass.hpp"

#include <cstdint>

#include "turgor/models/lattice/resample/rest_mass.hpp"

namespace turgor::lattice {

namespace {

/// Σ (HU + 1000) of a volume.
std::int64_t sum_of(const CtVolume& ct) {
  std::int64_t sum = 0;
  for (const std::int16_t hu : ct.samples) sum += hu - kAirHu;
  return sum;
}

}  // namespace

double image_mass_error(const Exec& exec, const Model& model, const State& rest, const CtVolume& ct,
                        const CtVolume& deformed) {
  const double body = rest_mass(exec, model, rest.cuts, ct);
  if (!(body > 0)) return 0;
  // the CT shows the whole body at rest on its own grid
  if (rest.cuts.removed_nodes == 0 && same_grid(ct.grid, deformed.grid))
    return double(sum_of(deformed) - sum_of(ct)) * sample_volume(deformed.grid) / body;
  const CtVolume before = resample_ct(exec, model, rest, ct, deformed.grid).ct;
  return double(sum_of(deformed) - sum_of(before)) * sample_volume(deformed.grid) / body;
}

}  // namespace turgor::lattice

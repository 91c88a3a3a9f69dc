#include "turgor/sim/deformed_ct.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"

namespace turgor {

DeformedCt make_deformed_ct(const Exec& exec, const LatticeBody& body, int frame, CtTargets targets,
                            int max_samples) {
  constexpr lattice::ResampleOptions kBodyOnly{.keep_surroundings = false};
  TURGOR_CHECK(max_samples > 0, "a deformed CT has samples");
  DeformedCt now{.frame = frame, .ct = {}, .targets = targets, .device = {}};
  const Grid& grid = body.ct.grid;

  // on the device, in the CT's own resolution
  if (targets.device) now.device = body.state.resample_on_device(exec, body.model, body.ct, grid, kBodyOnly);
  if (!targets.host && now.device) return now;

  // on the host, with a limited resolution
  const Int3 size = min(grid.size, Int3{max_samples, max_samples, max_samples});
  now.ct = body.state.resample(exec, body.model, body.ct, lattice::resized(grid, size), kBodyOnly).ct;
  return now;
}

}  // namespace turgor

#include "turgor/sim/deformed_ct.hpp"

#include <algorithm>

namespace turgor {

DeformedCt make_deformed_ct(const Exec& exec, const LatticeBody& body, int frame, CtWish wish, int most) {
  constexpr lattice::ResampleOptions kAlone{.keep_surroundings = false};
  DeformedCt now{.frame = frame, .ct = {}, .wish = wish, .there = {}};
  const Grid& grid = body.ct.grid;
  if (wish.there) now.there = body.state.resample_there(exec, body.model, body.ct, grid, kAlone);
  if (!wish.here && now.there) return now;
  const Int3 size = min(grid.size, Int3{most, most, most});
  now.ct = body.state.resample(exec, body.model, body.ct, lattice::resized(grid, size), kAlone).ct;
  return now;
}

}  // namespace turgor

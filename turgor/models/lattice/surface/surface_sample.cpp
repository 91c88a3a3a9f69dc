#include "turgor/models/lattice/surface/surface_sample.hpp"

#include <algorithm>

namespace turgor::lattice {

std::vector<int> places_in(std::span<const SurfaceSample> places, const State& state,
                           std::span<const Ball> balls) {
  std::vector<int> found;
  const auto u = [&](int slot) { return state.u[std::size_t(slot)]; };
  for (std::size_t p = 0; p < places.size(); p++) {
    const Vec3d x = places[p].rest + mean_at(places[p], u);
    if (std::any_of(balls.begin(), balls.end(), [&](const Ball& ball) { return contains(ball, x); }))
      found.push_back(int(p));
  }
  return found;
}

}  // namespace turgor::lattice

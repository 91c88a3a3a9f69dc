#include "turgor/models/lattice/surface/surface_sample.hpp"

#include <algorithm>

namespace turgor::lattice {

std::vector<int> samples_in_balls(std::span<const SurfaceSample> samples, const Motion& motion,
                                  std::span<const Ball> balls) {
  std::vector<int> found;
  const auto u = [&](int slot) { return motion.u[std::size_t(slot)]; };
  for (std::size_t p = 0; p < samples.size(); p++) {
    const Vec3d x = samples[p].rest + mean_at(samples[p], u);
    if (std::any_of(balls.begin(), balls.end(), [&](const Ball& ball) { return contains(ball, x); }))
      found.push_back(int(p));
  }
  return found;
}

}  // namespace turgor::lattice

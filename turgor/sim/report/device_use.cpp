#include "turgor/sim/report/device_use.hpp"

#include <algorithm>

namespace turgor {

double felt_stiffness(const TouchLog& log) {
  constexpr double kPiece = 1e-3, kStraight = 0.5;  // length [m], and share of it between the ends
  double stiffness = 0;
  std::size_t a = 0;
  for (std::size_t b = 0; b < log.size(); b++) {
    // latest sample that is a piece behind
    while (a + 1 < b && log[b].path - log[a + 1].path >= kPiece) a++;
    const double distance = norm(log[b].position - log[a].position);
    if (log[b].path - log[a].path < kPiece || distance < kStraight * kPiece) continue;
    stiffness = std::max(stiffness, (norm(log[b].force) - norm(log[a].force)) / distance);
  }
  return stiffness;
}

DeviceUse device_use(const TouchLog& log, double force) {
  DeviceUse use{.stiffness = felt_stiffness(log)};
  if (log.empty()) return use;
  Vec3d low = log[0].position, high = low;
  for (const ForceSample& sample : log) {
    use.force = std::max(use.force, norm(sample.force));
    use.saturated += force > 0 && norm(sample.force) > force;
    low = min(low, sample.position), high = max(high, sample.position);
  }
  const Vec3d size = high - low;
  use.reach = 0.5 * std::max({size.x, size.y, size.z});
  return use;
}

}  // namespace turgor

#include "turgor/contact/permit_depth.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::contact {

void permit_depth(std::span<const PairSite> last, double dt, std::span<PairSite> sites) {
  constexpr double kTime = 0.2;  // [s]
  const double kept = std::exp(-dt / kTime);
  auto before = last.begin();
  for (PairSite& site : sites) {
    while (before != last.end() && before->node < site.node) ++before;
    const bool is_known = before != last.end() && before->node == site.node;
    const double depth = std::max(0.0, -site.distance);
    site.permitted = is_known ? std::min(depth, before->permitted * kept) : depth;
    site.distance += site.permitted;
  }
}

}  // namespace turgor::contact

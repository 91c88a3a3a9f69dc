#include "turgor/core/timing.hpp"

#include <algorithm>
#include <cmath>

namespace turgor {

double percentile(std::vector<double> samples, double fraction) {
  if (samples.empty()) return 0;
  const double last = static_cast<double>(samples.size() - 1);
  const auto rank = static_cast<std::ptrdiff_t>(std::clamp(std::round(fraction * last), 0.0, last));
  std::nth_element(samples.begin(), samples.begin() + rank, samples.end());
  return samples[static_cast<std::size_t>(rank)];
}

}  // namespace turgor

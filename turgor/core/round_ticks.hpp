// Tick values of axes and color bars.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace turgor {

/// Round numbers (1, 2 or 5 times a power of ten apart) from low to high, about `count` of them, at least two
/// if `count` is four or more. Empty if the range is not finite.
inline std::vector<double> round_ticks(double low, double high, int count) {
  std::vector<double> ticks;
  if (!(high > low) || !std::isfinite(high - low)) return ticks;
  const double rough = (high - low) / std::max(count - 1, 1),
               decade = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = decade * (rough < 1.5 * decade   ? 1
                                : rough < 3.5 * decade ? 2
                                : rough < 7.5 * decade ? 5
                                                       : 10);
  if (!(step > 0)) return ticks;  // the range is too small for its decade to be representable
  const double slack = 1e-9 * (high - low);
  for (double i = std::ceil((low - slack) / step); i * step <= high + slack; i++)
    ticks.push_back(i * step + 0.0);
  return ticks;
}

}  // namespace turgor

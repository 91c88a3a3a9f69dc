// Small fits: non-negative linear least squares of up to four columns, and the Nelder-Mead simplex for the
// parameters that enter nonlinearly. Deterministic.
#pragma once

#include <functional>
#include <vector>

namespace turgor {

/// Coefficients c ≥ 0 of the columns that minimize Σ (Σⱼ cⱼ columnⱼ − b)², and the sum at the minimum. All
/// subsets of the columns are tried.
struct NonNegativeFit {
  std::vector<double> coefficients;
  double squared_error = 0;
};
NonNegativeFit fit_non_negative(const std::vector<std::vector<double>>& columns,
                                const std::vector<double>& b);

/// Parameters near a minimum of f, by a Nelder-Mead simplex with edges `size` around `start`.
std::vector<double> minimize(const std::function<double(const std::vector<double>&)>& f,
                             std::vector<double> start, double size, int steps);

}  // namespace turgor

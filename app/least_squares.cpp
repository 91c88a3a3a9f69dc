#include "app/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace turgor {

namespace {

double inner_product_of(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Solution of the normal equations of the chosen columns by elimination; empty if they are dependent.
std::vector<double> solve_normal(const std::vector<std::vector<double>>& columns,
                                 const std::vector<std::size_t>& chosen, const std::vector<double>& b) {
  const std::size_t n = chosen.size();
  std::vector<std::vector<double>> m(n, std::vector<double>(n + 1));
  for (std::size_t i = 0; i < n; i++) {
    for (std::size_t j = 0; j < n; j++) m[i][j] = inner_product_of(columns[chosen[i]], columns[chosen[j]]);
    m[i][n] = inner_product_of(columns[chosen[i]], b);
  }
  // the matrix is positive definite, so elimination needs no pivots
  for (std::size_t i = 0; i < n; i++) {
    if (!(m[i][i] > 1e-13 * inner_product_of(columns[chosen[i]], columns[chosen[i]]))) return {};
    for (std::size_t k = i + 1; k < n; k++) {
      const double factor = m[k][i] / m[i][i];
      for (std::size_t j = i; j <= n; j++) m[k][j] -= factor * m[i][j];
    }
  }
  std::vector<double> x(n);
  for (std::size_t i = n; i-- > 0;) {
    x[i] = m[i][n];
    for (std::size_t j = i + 1; j < n; j++) x[i] -= m[i][j] * x[j];
    x[i] /= m[i][i];
  }
  return x;
}

}  // namespace

NonNegativeFit fit_non_negative(const std::vector<std::vector<double>>& columns,
                                const std::vector<double>& b) {
  NonNegativeFit best{std::vector<double>(columns.size(), 0), inner_product_of(b, b)};
  for (unsigned subset = 1; subset < 1u << columns.size(); subset++) {
    // coefficients of this subset
    std::vector<std::size_t> chosen;
    for (std::size_t j = 0; j < columns.size(); j++)
      if (subset >> j & 1) chosen.push_back(j);
    const std::vector<double> x = solve_normal(columns, chosen, b);
    if (x.empty() || std::any_of(x.begin(), x.end(), [](double c) { return c < 0; })) continue;
    // error
    double error = 0;
    for (std::size_t n = 0; n < b.size(); n++) {
      double sum = -b[n];
      for (std::size_t j = 0; j < chosen.size(); j++) sum += x[j] * columns[chosen[j]][n];
      error += sum * sum;
    }
    if (!(error < best.squared_error)) continue;
    best = {std::vector<double>(columns.size(), 0), error};
    for (std::size_t j = 0; j < chosen.size(); j++) best.coefficients[chosen[j]] = x[j];
  }
  return best;
}

std::vector<double> minimize(const std::function<double(const std::vector<double>&)>& f,
                             std::vector<double> start, double size, int steps) {
  using Vertex = std::pair<double, std::vector<double>>;
  const std::size_t n = start.size();
  std::vector<Vertex> simplex{{f(start), start}};
  for (std::size_t i = 0; i < n; i++) {
    std::vector<double> moved = start;
    moved[i] += size;
    simplex.emplace_back(f(moved), moved);
  }
  for (int step = 0; step < steps; step++) {
    std::stable_sort(simplex.begin(), simplex.end(),
                     [](const Vertex& a, const Vertex& b) { return a.first < b.first; });
    // center of all vertices but the worst
    std::vector<double> center(n, 0);
    for (std::size_t v = 0; v < n; v++)
      for (std::size_t i = 0; i < n; i++) center[i] += simplex[v].second[i] / double(n);
    const auto along = [&](double by) {
      std::vector<double> x(n);
      for (std::size_t i = 0; i < n; i++) x[i] = center[i] + by * (simplex[n].second[i] - center[i]);
      return Vertex{f(x), x};
    };
    // reflect, expand, contract or shrink
    Vertex next = along(-1);
    if (next.first < simplex[0].first) {
      if (Vertex far = along(-2); far.first < next.first) next = std::move(far);
    } else if (!(next.first < simplex[n - 1].first)) {
      next = along(0.5);
    }
    if (next.first < simplex[n].first) {
      simplex[n] = std::move(next);
      continue;
    }
    for (std::size_t v = 1; v <= n; v++) {
      for (std::size_t i = 0; i < n; i++)
        simplex[v].second[i] = 0.5 * (simplex[v].second[i] + simplex[0].second[i]);
      simplex[v].first = f(simplex[v].second);
    }
  }
  return std::min_element(simplex.begin(), simplex.end(),
                          [](const Vertex& a, const Vertex& b) { return a.first < b.first; })
      ->second;
}

}  // namespace turgor

#include "turgor/contact/height_map.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Weights of four neighboring samples, and their first and second derivatives by the sample's number.
struct CubicWeights {
  double value[4], slope[4], bend[4];
  long first = 0;  // sample of the first weight
};
CubicWeights cubic_weights(double at, bool is_constant) {
  CubicWeights w{};
  const double whole = std::floor(at), t = at - whole;
  w.first = long(whole) - 1;
  if (is_constant) {
    w.value[1] = 1;
    return w;
  }
  // ½ [(−t + 2t² − t³), (2 − 5t² + 3t³), (t + 4t² − 3t³), (−t² + t³)]
  const double rows[4][4] = {{0, -1, 2, -1}, {2, 0, -5, 3}, {0, 1, 4, -3}, {0, 0, -1, 1}};
  for (int i = 0; i < 4; i++) {
    const double* c = rows[i];
    w.value[i] = 0.5 * (c[0] + t * (c[1] + t * (c[2] + t * c[3])));
    w.slope[i] = 0.5 * (c[1] + t * (2 * c[2] + 3 * t * c[3]));
    w.bend[i] = 0.5 * (2 * c[2] + 6 * t * c[3]);
  }
  return w;
}

long repeated(long i, long count) { return (i % count + count) % count; }

/// Largest absolute eigenvalue of the second derivatives.
double largest_bend(const HeightSample& s) {
  const double mean = 0.5 * (s.uu + s.vv), half = 0.5 * (s.uu - s.vv);
  return std::abs(mean) + std::sqrt(half * half + s.uv * s.uv);
}

}  // namespace

HeightSample sample_height(const HeightMap& map, double u, double v) {
  TURGOR_CHECK(map.columns > 0 && map.rows > 0 && map.spacing > 0, "a map has samples");
  const CubicWeights a = cubic_weights(u / map.spacing, map.columns == 1),
                     b = cubic_weights(v / map.spacing, map.rows == 1);
  HeightSample s;
  for (int j = 0; j < 4; j++) {
    const double* row = map.height.data() + repeated(b.first + j, map.rows) * static_cast<long>(map.columns);
    double value = 0, slope = 0, bend = 0;  // along the row
    for (int i = 0; i < 4; i++) {
      const double h = row[repeated(a.first + i, map.columns)];
      value += a.value[i] * h, slope += a.slope[i] * h, bend += a.bend[i] * h;
    }
    s.height += b.value[j] * value, s.u += b.value[j] * slope, s.uu += b.value[j] * bend;
    s.v += b.slope[j] * value, s.uv += b.slope[j] * slope, s.vv += b.bend[j] * value;
  }
  const double per = 1 / map.spacing;
  s.u *= per, s.v *= per, s.uu *= per * per, s.uv *= per * per, s.vv *= per * per;
  return s;
}

HeightMap make_height_map(int columns, int rows, double spacing, std::vector<double> height) {
  TURGOR_ASSERT(
      columns > 0 && rows > 0 && spacing > 0 && height.size() == std::size_t(columns) * std::size_t(rows),
      "a map has columns times rows heights");
  HeightMap map{.columns = columns, .rows = rows, .spacing = spacing, .height = std::move(height)};
  const auto [low, high] = std::minmax_element(map.height.begin(), map.height.end());
  map.range = *high - *low;
  // second derivatives are largest at samples or near them: four points along each spacing, from both sides
  constexpr double kPoints[] = {0, 1.0 / 3, 2.0 / 3, 1 - 1e-9};
  for (int j = 0; j < rows; j++)
    for (int i = 0; i < columns; i++)
      for (const double v : kPoints)
        for (const double u : kPoints)
          map.curvature =
              std::max(map.curvature, largest_bend(sample_height(map, (i + u) * spacing, (j + v) * spacing)));
  return map;
}

}  // namespace turgor::contact

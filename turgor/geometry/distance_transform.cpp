#include "turgor/geometry/distance_transform.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace turgor {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Calls work(line) for all lines of samples along an axis; line(i) is a reference to the line's sample i.
template <class Work>
void for_each_line(const Exec& exec, const Grid& grid, int axis, std::vector<float>& samples,
                   const Work& work) {
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const std::size_t strides[3] = {1, std::size_t(grid.size.x),
                                  std::size_t(grid.size.x) * std::size_t(grid.size.y)};
  exec.run_ranges(std::size_t(grid.size[v]), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<float> line(std::size_t(grid.size[axis]));
    for (std::size_t b = begin; b < end; b++)
      for (std::size_t a = 0; a < std::size_t(grid.size[u]); a++) {
        float* first = samples.data() + a * strides[u] + b * strides[v];
        for (std::size_t i = 0; i < line.size(); i++) line[i] = first[i * strides[axis]];
        work(line);
        for (std::size_t i = 0; i < line.size(); i++) first[i * strides[axis]] = line[i];
      }
  });
}

/// Lower envelope of the parabolas f(q) + (x − q)² at q = 0, h, 2h, …
struct Envelope {
  std::vector<double> apex, height,
      begin;  // of each parabola: apex, minimum, and start of the interval in which it is the lowest

  void add(double q, double f) {
    double from = -std::numeric_limits<double>::infinity();
    while (!apex.empty()) {
      const double p = apex.back();
      from = ((f + q * q) - (height.back() + p * p)) / (2 * (q - p));
      if (from > begin.back()) break;
      apex.pop_back(), height.pop_back(), begin.pop_back();
      from = -std::numeric_limits<double>::infinity();
    }
    apex.push_back(q), height.push_back(f), begin.push_back(from);
  }
};

/// Adds the squared distances along one more axis.
void transform_line(std::vector<float>& line, double h) {
  Envelope envelope;
  for (std::size_t i = 0; i < line.size(); i++)
    if (line[i] < kInfinity) envelope.add(double(i) * h, double(line[i]));
  if (envelope.apex.empty()) return;
  std::size_t k = 0;
  for (std::size_t i = 0; i < line.size(); i++) {
    const double x = double(i) * h;
    while (k + 1 < envelope.apex.size() && envelope.begin[k + 1] <= x) k++;
    const double d = x - envelope.apex[k];
    line[i] = float(envelope.height[k] + d * d);
  }
}

std::vector<double> gaussian_weights(double sigma) {
  std::vector<double> weights;
  double sum = 0;
  const int reach = int(std::ceil(3 * sigma));
  for (int i = -reach; i <= reach; i++) {
    weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    sum += weights.back();
  }
  for (double& w : weights) w /= sum;
  return weights;
}

}  // namespace

std::vector<float> distance_transform(const Exec& exec, const Grid& grid,
                                      const std::vector<std::uint8_t>& set) {
  std::vector<float> distance(set.size());
  for (std::size_t i = 0; i < set.size(); i++) distance[i] = set[i] ? 0 : kInfinity;
  for (int axis = 0; axis < 3; axis++)
    for_each_line(exec, grid, axis, distance,
                  [h = grid.spacing[axis]](std::vector<float>& line) { transform_line(line, h); });
  for (float& d : distance) d = std::sqrt(d);
  return distance;
}

void smooth_gaussian(const Exec& exec, const Grid& grid, double sigma, std::vector<float>& samples) {
  if (!(sigma > 0)) return;
  for (int axis = 0; axis < 3; axis++) {
    const std::vector<double> weights = gaussian_weights(sigma / grid.spacing[axis]);
    const int reach = int(weights.size() / 2), last = grid.size[axis] - 1;
    for_each_line(exec, grid, axis, samples, [&](std::vector<float>& line) {
      const std::vector<float> before = line;
      for (int i = 0; i <= last; i++) {
        double sum = 0;
        for (int j = -reach; j <= reach; j++)
          sum += weights[std::size_t(j + reach)] * double(before[std::size_t(std::clamp(i + j, 0, last))]);
        line[std::size_t(i)] = float(sum);
      }
    });
  }
}

}  // namespace turgor

#include "turgor/models/rhombus/surface_stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "turgor/core/assert.hpp"

namespace turgor::rhombus {

namespace {

constexpr int kLayers = 16, kSmoothings = 3;

Int3 nearest_sample(const Grid& grid, Vec3d position) {
  const Vec3d index = index_at(grid, position);
  const auto whole = [](double x) { return int(std::lround(std::min(std::max(x, -2.0), 1e6))); };
  return {whole(index.x), whole(index.y), whole(index.z)};
}

/// Mean over each vertex and its neighbors.
std::vector<double> smoothed(const Surface& s, const std::vector<double>& value) {
  TURGOR_CHECK(value.size() == s.vertices.size(), "every vertex has a value");
  std::vector<double> sum = value;
  std::vector<double> count(value.size(), 1);
  for (const Int3 t : s.triangles)
    for (int i = 0; i < 3; i++) {  // each edge occurs twice, once in each direction
      sum[std::size_t(t[i])] += value[std::size_t(t[(i + 1) % 3])];
      count[std::size_t(t[i])]++;
    }
  for (std::size_t v = 0; v < sum.size(); v++) sum[v] /= count[v];
  return sum;
}

}  // namespace

std::vector<double> stiffness_below(const Surface& surface, double depth,
                                    const std::function<double(Vec3d)>& factor) {
  TURGOR_ASSERT(depth > 0, "the depth of the stiffness layers is positive");
  std::vector<double> stiffness(surface.vertices.size());
  for (std::size_t v = 0; v < stiffness.size(); v++) {
    double compliance = 0, weights = 0;
    for (int layer = 0; layer < kLayers; layer++) {
      const double fraction = (layer + 0.5) / kLayers, weight = 1 - fraction;
      compliance += weight / factor(surface.vertices[v] - surface.normals[v] * (fraction * depth));
      weights += weight;
    }
    stiffness[v] = weights / compliance;
  }
  for (int i = 0; i < kSmoothings; i++) stiffness = smoothed(surface, stiffness);
  return stiffness;
}

std::function<double(Vec3d)> factor_of_labels(const LabelVolume& labels, std::map<int, double> factors) {
  return [&labels, factors = std::move(factors)](Vec3d position) {
    const Int3 p = nearest_sample(labels.grid, position);
    if (!contains(labels.grid, p)) return 1.0;
    const auto found = factors.find(labels.at(p.x, p.y, p.z));
    return found == factors.end() ? 1.0 : found->second;
  };
}

std::function<double(Vec3d)> factor_of_ct(const CtVolume& ct, std::map<double, double> factors) {
  TURGOR_ASSERT(!factors.empty(), "at least one CT value has a factor");
  return [&ct, factors = std::move(factors)](Vec3d position) {
    const Int3 p = nearest_sample(ct.grid, position);
    if (!contains(ct.grid, p)) return 1.0;
    const double hu = ct.at(p.x, p.y, p.z);
    const auto above = factors.lower_bound(hu);
    if (above == factors.begin()) return above->second;
    const auto below = std::prev(above);
    if (above == factors.end()) return below->second;
    const double fraction = (hu - below->first) / (above->first - below->first);
    return below->second * (1 - fraction) + above->second * fraction;
  };
}

}  // namespace turgor::rhombus

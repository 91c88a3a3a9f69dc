#include "turgor/models/sfem/patch_levels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::sfem {

namespace {

constexpr double kAlike = 0.7;   // cosine between the normals of what is merged, at least
constexpr double kRigid = 1e-9;  // of the softest point: what is stiffer cannot be moved
constexpr double kSlow = 0.85;   // a level with more than this part of the clusters before is not worth it

/// Clusters while they are merged.
struct Places {
  std::vector<Vec3d> center, normal;
  std::vector<double> area;
  std::vector<std::uint8_t> alone;  // 1: never merged
  std::vector<std::vector<int>> neighbors;
};

Places places_of_points(const Patch& patch) {
  const std::size_t n = patch.points.size();
  Places places{std::vector<Vec3d>(n), std::vector<Vec3d>(n), std::vector<double>(n),
                std::vector<std::uint8_t>(n), std::vector<std::vector<int>>(n)};
  for (const Int3 t : patch.triangles) {
    const auto x = [&](int corner) { return patch.points[std::size_t(t[corner])].x; };
    const Vec3d product = cross(x(1) - x(0), x(2) - x(0));
    for (int corner = 0; corner < 3; corner++) {
      const auto p = std::size_t(t[corner]);
      places.normal[p] += product;
      places.area[p] += norm(product) / 6;
      for (const int other : {t[(corner + 1) % 3], t[(corner + 2) % 3]}) places.neighbors[p].push_back(other);
    }
  }
  double softest = 0;
  const auto softness = [&](std::size_t p) { return patch.compliance[(9 * n + 3) * p]; };
  for (std::size_t p = 0; p < n; p++) softest = std::max(softest, softness(p));
  for (std::size_t p = 0; p < n; p++) {
    places.center[p] = patch.points[p].x, places.normal[p] = normalized(places.normal[p]);
    places.alone[p] = !(softness(p) > kRigid * softest);
  }
  return places;
}

/// Every place with the nearest free neighbour that faces its way; what finds none joins the smallest one.
/// The new number of each, in the order of the first of a pair.
std::vector<int> merge_pairs(const Places& places, int& count) {
  const std::size_t n = places.center.size();
  std::vector<int> merged(n, -1), left;
  const auto find = [&](std::size_t a, bool free, const auto& cost) {
    int best = -1;
    for (const int b : places.neighbors[a]) {
      const auto other = std::size_t(b);
      if (other == a || (merged[other] < 0) != free || places.alone[other] != 0) continue;
      if (dot(places.normal[a], places.normal[other]) < kAlike) continue;
      if (best < 0 || cost(other) < cost(std::size_t(best))) best = b;
    }
    return best;
  };
  count = 0;
  for (std::size_t a = 0; a < n; a++) {
    if (merged[a] >= 0) continue;
    const auto apart = [&](std::size_t b) { return norm(places.center[b] - places.center[a]); };
    const int pair = places.alone[a] != 0 ? -1 : find(a, true, apart);
    if (pair < 0 && places.alone[a] == 0) {
      left.push_back(int(a));
      continue;
    }
    merged[a] = count++;
    if (pair >= 0) merged[std::size_t(pair)] = merged[a];
  }
  for (const int a : left) {
    const int host = find(std::size_t(a), false, [&](std::size_t b) { return places.area[b]; });
    merged[std::size_t(a)] = host >= 0 ? merged[std::size_t(host)] : count++;
  }
  return merged;
}

Places merged_places(const Places& from, const std::vector<int>& merged, std::size_t count) {
  Places to{std::vector<Vec3d>(count), std::vector<Vec3d>(count), std::vector<double>(count),
            std::vector<std::uint8_t>(count), std::vector<std::vector<int>>(count)};
  for (std::size_t a = 0; a < merged.size(); a++) {
    const auto m = std::size_t(merged[a]);
    to.area[m] += from.area[a];
    to.center[m] += from.area[a] * from.center[a], to.normal[m] += from.area[a] * from.normal[a];
    to.alone[m] = from.alone[a];
    for (const int b : from.neighbors[a])
      if (const int other = merged[std::size_t(b)]; other != merged[a]) to.neighbors[m].push_back(other);
  }
  for (std::size_t m = 0; m < count; m++) {
    to.center[m] = to.center[m] / to.area[m], to.normal[m] = normalized(to.normal[m]);
    std::vector<int>& near = to.neighbors[m];
    sort_unique(near);
  }
  return to;
}

/// The points of every cluster, with the part of its force that each bears.
PatchLevel list_points(std::vector<int> cluster, const std::vector<double>& area, std::size_t count) {
  PatchLevel level{.cluster = std::move(cluster), .first = std::vector<int>(count + 1)};
  std::vector<double> whole(count);
  for (std::size_t p = 0; p < area.size(); p++) {
    const auto c = std::size_t(level.cluster[p]);
    level.first[c + 1]++, whole[c] += area[p];
  }
  for (std::size_t c = 0; c < count; c++) level.first[c + 1] += level.first[c];
  std::vector<int> next(level.first.begin(), level.first.end() - 1);
  level.points.resize(area.size()), level.share.resize(area.size());
  for (std::size_t p = 0; p < area.size(); p++) {
    const auto c = std::size_t(level.cluster[p]);
    const auto at = std::size_t(next[c]++);
    level.points[at] = int(p), level.share[at] = area[p] / whole[c];
  }
  return level;
}

/// Ξ B and Bᵀ Ξ B.
void sum_compliance(const Patch& patch, PatchLevel& level) {
  const std::size_t rows = 3 * patch.points.size(), count = cluster_count(level);
  level.motion.assign(3 * count * rows, 0);
  level.compliance.assign(9 * count * count, 0);
  for (std::size_t c = 0; c < count; c++)
    for (std::size_t axis = 0; axis < 3; axis++) {
      double* column = &level.motion[(3 * c + axis) * rows];
      for (auto m = std::size_t(level.first[c]); m < std::size_t(level.first[c + 1]); m++) {
        const double* from = &patch.compliance[(3 * std::size_t(level.points[m]) + axis) * rows];
        for (std::size_t i = 0; i < rows; i++) column[i] += level.share[m] * from[i];
      }
      double* mean = &level.compliance[(3 * c + axis) * 3 * count];
      for (std::size_t m = 0; m < level.points.size(); m++) {
        const auto p = std::size_t(level.points[m]), row = std::size_t(level.cluster[p]);
        for (std::size_t i = 0; i < 3; i++) mean[3 * row + i] += level.share[m] * column[3 * p + i];
      }
    }
}

}  // namespace

void add_levels(Patch& patch, std::size_t fewest) {
  patch.levels.clear();
  Places places = places_of_points(patch);
  const std::vector<double> area = places.area;
  std::vector<int> cluster(area.size());
  for (std::size_t p = 0; p < cluster.size(); p++) cluster[p] = int(p);
  while (places.center.size() > fewest) {
    int count = 0;
    const std::vector<int> merged = merge_pairs(places, count);
    if (double(count) > kSlow * double(places.center.size())) break;
    for (int& c : cluster) c = merged[std::size_t(c)];
    places = merged_places(places, merged, std::size_t(count));
    patch.levels.push_back(list_points(cluster, area, std::size_t(count)));
    sum_compliance(patch, patch.levels.back());
  }
}

}  // namespace turgor::sfem

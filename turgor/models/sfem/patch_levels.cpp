#include "turgor/models/sfem/patch_levels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor::sfem {

namespace {

constexpr double kMinCosine = 0.7;  // smallest cosine between the normals of merged clusters
constexpr double kRigid = 1e-9;     // relative to the softest point: stiffer points cannot move
constexpr double kMaxRatio = 0.85;  // largest ratio of cluster numbers between two levels

/// Clusters while they are merged.
struct Clusters {
  std::vector<Vec3d> center, normal;
  std::vector<double> area;
  std::vector<std::uint8_t> alone;  // 1: never merged
  std::vector<std::vector<int>> neighbors;
};

Clusters clusters_of_points(const Patch& patch) {
  const std::size_t n = patch.points.size();
  Clusters clusters{std::vector<Vec3d>(n), std::vector<Vec3d>(n), std::vector<double>(n),
                    std::vector<std::uint8_t>(n), std::vector<std::vector<int>>(n)};
  for (const Int3 t : patch.triangles) {
    // normals, areas and neighbors
    const auto x = [&](int corner) { return patch.points[std::size_t(t[corner])].x; };
    const Vec3d product = cross(x(1) - x(0), x(2) - x(0));
    for (int corner = 0; corner < 3; corner++) {
      const auto p = std::size_t(t[corner]);
      clusters.normal[p] += product;
      clusters.area[p] += norm(product) / 6;
      for (const int other : {t[(corner + 1) % 3], t[(corner + 2) % 3]})
        clusters.neighbors[p].push_back(other);
    }
  }
  // rigid points are never merged
  double softest = 0;
  TURGOR_CHECK(patch.compliance.size() == 9 * n * n,
               "the compliance has three rows and three columns per point");
  const auto softness = [&](std::size_t p) { return patch.compliance[(9 * n + 3) * p]; };
  for (std::size_t p = 0; p < n; p++) softest = std::max(softest, softness(p));
  for (std::size_t p = 0; p < n; p++) {
    clusters.center[p] = patch.points[p].x, clusters.normal[p] = normalized(clusters.normal[p]);
    clusters.alone[p] = !(softness(p) > kRigid * softest);
  }
  return clusters;
}

/// Merges every cluster with the nearest free neighbor of similar normal. A cluster without one joins the
/// smallest neighbor. Returns the new number of each, in the order of the first of a pair.
std::vector<int> merge_pairs(const Clusters& clusters, int& count) {
  const std::size_t n = clusters.center.size();
  std::vector<int> merged(n, -1), left;
  const auto find = [&](std::size_t a, bool free, const auto& cost) {
    int best = -1;
    for (const int b : clusters.neighbors[a]) {
      const auto other = std::size_t(b);
      if (other == a || (merged[other] < 0) != free || clusters.alone[other] != 0) continue;
      if (dot(clusters.normal[a], clusters.normal[other]) < kMinCosine) continue;
      if (best < 0 || cost(other) < cost(std::size_t(best))) best = b;
    }
    return best;
  };
  count = 0;
  for (std::size_t a = 0; a < n; a++) {
    if (merged[a] >= 0) continue;
    const auto apart = [&](std::size_t b) { return norm(clusters.center[b] - clusters.center[a]); };
    const int pair = clusters.alone[a] != 0 ? -1 : find(a, true, apart);
    if (pair < 0 && clusters.alone[a] == 0) {
      left.push_back(int(a));
      continue;
    }
    merged[a] = count++;
    if (pair >= 0) merged[std::size_t(pair)] = merged[a];
  }
  for (const int a : left) {
    const int host = find(std::size_t(a), false, [&](std::size_t b) { return clusters.area[b]; });
    merged[std::size_t(a)] = host >= 0 ? merged[std::size_t(host)] : count++;
  }
  TURGOR_CHECK(all_indices(merged, std::size_t(count)), "the numbers of clusters lie below their count");
  return merged;
}

Clusters merged_clusters(const Clusters& from, const std::vector<int>& merged, std::size_t count) {
  Clusters to{std::vector<Vec3d>(count), std::vector<Vec3d>(count), std::vector<double>(count),
              std::vector<std::uint8_t>(count), std::vector<std::vector<int>>(count)};
  for (std::size_t a = 0; a < merged.size(); a++) {
    const auto m = std::size_t(merged[a]);
    // area-weighted sums
    to.area[m] += from.area[a];
    to.center[m] += from.area[a] * from.center[a], to.normal[m] += from.area[a] * from.normal[a];
    to.alone[m] = from.alone[a];
    for (const int b : from.neighbors[a])
      if (const int other = merged[std::size_t(b)]; other != merged[a]) to.neighbors[m].push_back(other);
  }
  for (std::size_t m = 0; m < count; m++) {
    // means; unique neighbors
    TURGOR_CHECK(to.area[m] > 0, "a cluster has an area");
    to.center[m] = to.center[m] / to.area[m], to.normal[m] = normalized(to.normal[m]);
    std::vector<int>& near = to.neighbors[m];
    sort_unique(near);
  }
  return to;
}

/// Points of every cluster, with their shares of its force.
PatchLevel list_points(std::vector<int> cluster, const std::vector<double>& area, std::size_t count) {
  PatchLevel level{.cluster = std::move(cluster), .first = std::vector<int>(count + 1)};
  // number of points and area of each cluster
  std::vector<double> whole(count);
  for (std::size_t p = 0; p < area.size(); p++) {
    const auto c = std::size_t(level.cluster[p]);
    level.first[c + 1]++, whole[c] += area[p];
  }
  for (std::size_t c = 0; c < count; c++) level.first[c + 1] += level.first[c];
  // points and their shares
  std::vector<int> next(level.first.begin(), level.first.end() - 1);
  level.points.resize(area.size()), level.share.resize(area.size());
  for (std::size_t p = 0; p < area.size(); p++) {
    const auto c = std::size_t(level.cluster[p]);
    const auto at = std::size_t(next[c]++);
    level.points[at] = int(p), level.share[at] = area[p] / whole[c];
  }
  TURGOR_CHECK(is_csr(level.first, level.points.size()), "the clusters cover all points");
  return level;
}

/// Ξ B and Bᵀ Ξ B.
void sum_compliance(const Patch& patch, PatchLevel& level) {
  const std::size_t rows = 3 * patch.points.size(), count = cluster_count(level);
  level.motion.assign(3 * count * rows, 0);
  level.compliance.assign(9 * count * count, 0);
  for (std::size_t c = 0; c < count; c++)
    for (std::size_t axis = 0; axis < 3; axis++) {
      // Ξ B
      double* column = &level.motion[(3 * c + axis) * rows];
      for (auto m = std::size_t(level.first[c]); m < std::size_t(level.first[c + 1]); m++) {
        const double* from = &patch.compliance[(3 * std::size_t(level.points[m]) + axis) * rows];
        for (std::size_t i = 0; i < rows; i++) column[i] += level.share[m] * from[i];
      }
      // Bᵀ Ξ B
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
  // one cluster a point
  Clusters clusters = clusters_of_points(patch);
  const std::vector<double> area = clusters.area;
  std::vector<int> cluster(area.size());
  for (std::size_t p = 0; p < cluster.size(); p++) cluster[p] = int(p);
  while (clusters.center.size() > fewest) {
    // merge pairs
    int count = 0;
    const std::vector<int> merged = merge_pairs(clusters, count);
    if (double(count) > kMaxRatio * double(clusters.center.size())) break;
    // next level
    for (int& c : cluster) c = merged[std::size_t(c)];
    clusters = merged_clusters(clusters, merged, std::size_t(count));
    patch.levels.push_back(list_points(cluster, area, std::size_t(count)));
    sum_compliance(patch, patch.levels.back());
  }
}

}  // namespace turgor::sfem

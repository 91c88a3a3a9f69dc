// Coarser pressures on a patch's surface: its points in clusters of two, four, eight … neighbors, each with
// even pressure. A wide tool presses a few such clusters instead of hundreds of points. Their influence on
// all points and on each other is summed once, when the patch is built.
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor::sfem {

struct Patch;

/// Clusters of one size. A unit force on a cluster is distributed over its points by `share`, and a cluster's
/// displacement is the mean of its points by the same weights: B of Ξ B and Bᵀ Ξ B.
struct PatchLevel {
  std::vector<int> cluster;        // of each point
  std::vector<int> first;          // index of each cluster's first entry in `points`, and an end
  std::vector<int> points;         // cluster after cluster
  std::vector<double> share;       // of each of `points` in its cluster, by area; sum 1 a cluster [1]
  std::vector<double> motion;      // Ξ B, 3·points × 3·clusters, column-major [m/N]
  std::vector<double> compliance;  // Bᵀ Ξ B, 3·clusters square, column-major [m/N]
};
inline std::size_t cluster_count(const PatchLevel& level) { return level.first.size() - 1; }

/// Makes Patch::levels, each with about half of the clusters of the one before, until at most `fewest`
/// remain. Points with different normals, and points that cannot move, are not merged.
void add_levels(Patch& patch, std::size_t fewest = 12);

}  // namespace turgor::sfem

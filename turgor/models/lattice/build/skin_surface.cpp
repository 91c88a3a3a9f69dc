#include "turgor/models/lattice/build/skin_surface.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor::lattice {

namespace {

/// Smoothing passes. Each one moves a node halfway to the mean of its neighbors. Together they spread a stair
/// of one spacing over about seven.
constexpr int kPasses = 40;

/// Neighbors of each skin node; empty at the border.
struct Adjacency {
  std::vector<int> begin, nodes;
};

Adjacency adjacent_nodes(const std::vector<Int3>& triangles, std::size_t count) {
  TURGOR_CHECK(all_indices(triangles, count), "the corners of triangles are nodes of the skin");
  Adjacency adjacency;
  adjacency.begin.assign(count + 1, 0);
  std::vector<std::int64_t> boundary_sum(count);  // 0 where the triangles around a node form a closed fan
  // sums over the triangles
  for (const Int3 t : triangles)
    for (int c = 0; c < 3; c++) {
      adjacency.begin[std::size_t(t[c]) + 1]++;
      boundary_sum[std::size_t(t[c])] += t[(c + 1) % 3] - t[(c + 2) % 3];
    }
  // ranges
  for (std::size_t n = 0; n < count; n++)
    adjacency.begin[n + 1] = adjacency.begin[n] + (boundary_sum[n] == 0 ? adjacency.begin[n + 1] : 0);
  adjacency.nodes.resize(std::size_t(adjacency.begin[count]));
  std::vector<int> end(adjacency.begin.begin(), adjacency.begin.end() - 1);
  // neighbors of inner nodes
  for (const Int3 t : triangles)
    for (int c = 0; c < 3; c++)
      if (const auto n = std::size_t(t[c]); boundary_sum[n] == 0)
        adjacency.nodes[std::size_t(end[n]++)] = t[(c + 1) % 3];
  TURGOR_CHECK(is_csr(adjacency.begin, adjacency.nodes.size()), "the offsets cover all adjacent nodes");
  return adjacency;
}

struct Pass {
  const Adjacency& adjacency;
  const Vec3d* from;
  Vec3d* to;

  void operator()(std::size_t n) const {
    const int begin = adjacency.begin[n], end = adjacency.begin[n + 1];
    Vec3d sum;
    for (int at = begin; at < end; at++) sum += from[adjacency.nodes[std::size_t(at)]];
    to[n] = begin < end ? from[n] * 0.5 + sum * (0.5 / (end - begin)) : from[n];
  }
};

std::vector<Vec3d> smoothed(const Exec& exec, const Adjacency& adjacency, std::vector<Vec3d> positions) {
  std::vector<Vec3d> next(positions.size());
  for (int pass = 0; pass < kPasses; pass++) {
    parallel_for(exec, positions.size(), Pass{adjacency, positions.data(), next.data()}, 1024);
    std::swap(positions, next);
  }
  return positions;
}

/// Rest position of a node, given by its index in the whole body [m].
Vec3d rest_position_of(const Lattice& lattice, std::int64_t number) {
  const std::int64_t row = number / lattice.size.x;
  return Vec3d(rest_position(lattice, {int(number % lattice.size.x), int(row % lattice.size.y),
                                       int(row / lattice.size.y) - lattice.first}));
}

}  // namespace

std::size_t SmoothedSkin::index_of(std::int64_t node) const {
  TURGOR_CHECK(std::binary_search(node_.begin(), node_.end(), node), "the node belongs to the skin");
  return std::size_t(std::lower_bound(node_.begin(), node_.end(), node) - node_.begin());
}

SmoothedSkin::SmoothedSkin(const Exec& exec, const Lattice& lattice,
                           const std::vector<SkinNodes>& triangles) {
  // nodes and rest positions
  for (const SkinNodes& t : triangles) node_.insert(node_.end(), t.begin(), t.end());
  sort_unique(node_);
  for (const std::int64_t node : node_) position_.push_back(rest_position_of(lattice, node));

  // adjacency
  std::vector<Int3> corners;
  for (const SkinNodes& t : triangles)
    corners.push_back({int(index_of(t[0])), int(index_of(t[1])), int(index_of(t[2]))});
  const Adjacency adjacency = adjacent_nodes(corners, position_.size());
  // Twicing: smoothing removes from a surface about what it removes from the smoothed surface.
  const std::vector<Vec3d> once = smoothed(exec, adjacency, position_),
                           twice = smoothed(exec, adjacency, once);
  const double most = double(std::min({lattice.spacing.x, lattice.spacing.y, lattice.spacing.z}));
  for (std::size_t n = 0; n < position_.size(); n++) {
    const Vec3d correction = once[n] * 2.0 - twice[n] - position_[n];
    position_[n] += correction * std::min(1.0, most / std::max(norm(correction), 1e-9));
  }
}

}  // namespace turgor::lattice

#include "turgor/models/lattice/build/skin_surface.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/sort_unique.hpp"

namespace turgor::lattice {

namespace {

/// Each pass takes a node halfway to the mean of those beside it: all of them spread a step of the lattice
/// over some seven.
constexpr int kPasses = 40;

/// The nodes beside each node of skin; none at its border.
struct Beside {
  std::vector<int> begin, nodes;
};

Beside nodes_beside(const std::vector<Int3>& triangles, std::size_t count) {
  Beside beside;
  beside.begin.assign(count + 1, 0);
  std::vector<std::int64_t> turn(count);  // 0 where the triangles around a node close
  for (const Int3 t : triangles)
    for (int c = 0; c < 3; c++) {
      beside.begin[std::size_t(t[c]) + 1]++;
      turn[std::size_t(t[c])] += t[(c + 1) % 3] - t[(c + 2) % 3];
    }
  for (std::size_t n = 0; n < count; n++)
    beside.begin[n + 1] = beside.begin[n] + (turn[n] == 0 ? beside.begin[n + 1] : 0);
  beside.nodes.resize(std::size_t(beside.begin[count]));
  std::vector<int> end(beside.begin.begin(), beside.begin.end() - 1);
  for (const Int3 t : triangles)
    for (int c = 0; c < 3; c++)
      if (const auto n = std::size_t(t[c]); turn[n] == 0)
        beside.nodes[std::size_t(end[n]++)] = t[(c + 1) % 3];
  return beside;
}

struct Pass {
  const Beside& beside;
  const Vec3d* from;
  Vec3d* to;

  void operator()(std::size_t n) const {
    const int begin = beside.begin[n], end = beside.begin[n + 1];
    Vec3d sum;
    for (int at = begin; at < end; at++) sum += from[beside.nodes[std::size_t(at)]];
    to[n] = begin < end ? from[n] * 0.5 + sum * (0.5 / (end - begin)) : from[n];
  }
};

std::vector<Vec3d> smoothed(const Exec& exec, const Beside& beside, std::vector<Vec3d> places) {
  std::vector<Vec3d> next(places.size());
  for (int pass = 0; pass < kPasses; pass++) {
    parallel_for(exec, places.size(), Pass{beside, places.data(), next.data()}, 1024);
    std::swap(places, next);
  }
  return places;
}

/// Where a node of the whole body is at rest, likewise [m].
Vec3d place_of(const Lattice& lattice, std::int64_t number) {
  const std::int64_t row = number / lattice.size.x;
  return Vec3d(rest_position(lattice, {int(number % lattice.size.x), int(row % lattice.size.y),
                                       int(row / lattice.size.y) - lattice.first}));
}

}  // namespace

std::size_t SkinPlaces::index_of(std::int64_t node) const {
  return std::size_t(std::lower_bound(node_.begin(), node_.end(), node) - node_.begin());
}

SkinPlaces::SkinPlaces(const Exec& exec, const Lattice& lattice, const std::vector<SkinNodes>& triangles) {
  for (const SkinNodes& t : triangles) node_.insert(node_.end(), t.begin(), t.end());
  sort_unique(node_);
  for (const std::int64_t node : node_) place_.push_back(place_of(lattice, node));

  std::vector<Int3> corners;
  for (const SkinNodes& t : triangles)
    corners.push_back({int(index_of(t[0])), int(index_of(t[1])), int(index_of(t[2]))});
  const Beside beside = nodes_beside(corners, place_.size());
  // What smoothing takes from a curved surface it takes twice from one that is smooth already, and so is
  // known.
  const std::vector<Vec3d> once = smoothed(exec, beside, place_), twice = smoothed(exec, beside, once);
  const double most = double(std::min({lattice.step.x, lattice.step.y, lattice.step.z}));
  for (std::size_t n = 0; n < place_.size(); n++) {
    const Vec3d way = once[n] * 2.0 - twice[n] - place_[n];
    place_[n] += way * std::min(1.0, most / std::max(norm(way), 1e-9));
  }
}

}  // namespace turgor::lattice

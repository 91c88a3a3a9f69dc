// Contacts of large triangles and edges on one side of a bus or the other: a thread each, in the order of the
// CPU's list (contact_large.cpp).
#pragma once

#include <cmath>

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/contact/large_primitive_kernels.hpp"
#include "turgor/models/cloth/device/device_found.hpp"
#include "turgor/models/cloth/device/device_spatial_hash.hpp"

namespace turgor::cloth {

using EdgeEnds = std::array<int, 2>;

/// Middles of the edges, and the square of the longest.
struct PlaceMidpoint {
  const EdgeEnds* edges;
  ConstVectorsView x;
  VectorsView middles;
  std::uint32_t* longest2;  // bits

  TURGOR_HD void operator()(std::size_t e) const {
    const Vec3 a = x[std::size_t(edges[e][0])], b = x[std::size_t(edges[e][1])];
    middles.set(e, (a + b) * Real(0.5));
    atomic_max(*longest2, magnitude_bits(dot(b - a, b - a)));
  }
};

struct CoarseTriangles {
  const Int3* list;
  std::size_t count;

  TURGOR_HD Range around(const CoarseView& view, std::size_t n) const { return view.around(list[n]); }
};
struct CoarseEdges {
  const EdgeEnds* list;
  std::size_t count;
  const std::uint32_t* longest2;  // bits

  TURGOR_HD Real longest_half() const { return std::sqrt(std::bit_cast<Real>(*longest2)) / 2; }
  TURGOR_HD Range around(const CoarseView& view, std::size_t n) const {
    return view.around(list[n], longest_half());
  }
};

/// Around a block of triangles or of edges.
template <class Items>
struct PlaceBlock {
  CoarseView view;
  Items items;
  Range* blocks;

  TURGOR_HD void operator()(std::size_t block) const {
    const std::size_t first = block * kCoarseBlock;
    Range range = items.around(view, first);
    for (std::size_t n = first + 1; n < items.count && n < first + kCoarseBlock; n++)
      range = joined(range, items.around(view, n));
    blocks[block] = range;
  }
};

/// Points near one of a block, in the CPU's order: where its block has all of them, so has it.
template <class Take>
TURGOR_HD inline void visit_of_block(const NearView& points, const Range& block, Vec3 low, Vec3 high,
                                     const Take& take) {
  if (points.is_all(block.low, block.high))
    points.visit(block.low, block.high, take);
  else
    points.visit(low, high, take);
}

struct FindOfTriangle {
  CoarseView view;
  CoarseTriangles triangles;
  NearView vertices;
  const Range* blocks;
  Found found;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 t = triangles.list[n];
    const NearTriangle sieve = view.sieve(t);
    found(n, [&](const auto& take) {
      visit_of_block(vertices, blocks[n / kCoarseBlock], sieve.low, sieve.high, [&](int v, Vec3 place) {
        Contact contact;
        if (sieve.passes<Real>(place, view.at_rest(v)) && view.touch(t, v, contact)) take(contact);
      });
    });
  }
};

struct FindOfEdge {
  CoarseView view;
  CoarseEdges edges;
  NearView midpoints;
  const Range* blocks;
  Found found;

  TURGOR_HD void operator()(std::size_t n) const {
    const EdgeEnds ends = edges.list[n];
    const NearEdge sieve = view.sieve(ends, edges.longest_half());
    found(n, [&](const auto& take) {
      visit_of_block(midpoints, blocks[n / kCoarseBlock], sieve.low, sieve.high, [&](int other, Vec3 middle) {
        if (std::size_t(other) <= n) return;
        const EdgeEnds others = edges.list[other];
        const Vec3 rest_a = view.at_rest(others[0]), rest_b = view.at_rest(others[1]);
        Contact contact;
        if (sieve.passes<Real>(middle, view.at(others[1]) - view.at(others[0]), (rest_a + rest_b) * Real(0.5),
                               rest_b - rest_a) &&
            view.touch(ends, others, contact))
          take(contact);
      });
    });
  }
};

template <class Side>
class DeviceCoarse {
 public:
  DeviceCoarse(DeviceAllocator<Side>& rooms, const Model& m)
      : triangles_(rooms.copy(m.coarse.triangles)),
        edges_(rooms.copy(m.coarse.edges)),
        middles_(rooms, m.coarse.edges.size()),
        midpoints_(rooms, m.coarse.edges.size()),
        longest2_(rooms.template room<std::uint32_t>(m.coarse.edges.empty() ? 0 : 1)),
        blocks_(rooms.template room<Range>(block_count(triangles_) + block_count(edges_))),
        longest_(m.coarse.longest) {}

  /// Triangles, then edges: as many numbers of contacts.
  std::size_t count() const { return triangles_.size() + edges_.size(); }
  /// Where they and the middles of edges lie.
  template <class Run>
  void place(const Run& run, const CoarseView& coarse) {
    if (edges_.size() == 0) return;
    const std::uint32_t none = 0;
    longest2_.upload({&none, 1});
    run(edges_.size(), PlaceMidpoint{edges_.data(), coarse.x, view(middles_), longest2_.data()});
    midpoints_view_ = midpoints_.sort(run, view(middles_), longest_);
    run(block_count(triangles_), PlaceBlock<CoarseTriangles>{coarse, triangles(), blocks_.data()});
    run(block_count(edges_), PlaceBlock<CoarseEdges>{coarse, edges(), edge_blocks()});
  }
  template <class Run>
  void find(const Run& run, const CoarseView& coarse, const NearView& vertices, Found found) const {
    run(triangles_.size(), FindOfTriangle{coarse, triangles(), vertices, blocks_.data(), found});
    found.count += triangles_.size();
    run(edges_.size(), FindOfEdge{coarse, edges(), midpoints_view_, edge_blocks(), found});
  }

 private:
  template <class Array>
  static std::size_t block_count(const Array& items) {
    return (items.size() + kCoarseBlock - 1) / kCoarseBlock;
  }
  CoarseTriangles triangles() const { return {triangles_.data(), triangles_.size()}; }
  CoarseEdges edges() const { return {edges_.data(), edges_.size(), longest2_.data()}; }
  Range* edge_blocks() const { return blocks_.data() + block_count(triangles_); }

  typename Side::template Array<Int3> triangles_;
  typename Side::template Array<EdgeEnds> edges_;
  DeviceVectors<Side> middles_;
  DeviceSpatialHash<Side> midpoints_;
  NearView midpoints_view_{};
  typename Side::template Array<std::uint32_t> longest2_;
  typename Side::template Array<Range> blocks_;  // of triangles, then of edges
  Real longest_;                                 // at rest [m]
};

}  // namespace turgor::cloth

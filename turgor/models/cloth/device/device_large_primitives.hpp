// Contacts of large triangles and edges on the device: one thread each, in the order of the host's list
// (contact_large.cpp).
#pragma once

#include <cmath>

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/contact/large_primitive_kernels.hpp"
#include "turgor/models/cloth/device/device_found.hpp"
#include "turgor/models/cloth/device/device_spatial_hash.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

using EdgeEnds = std::array<int, 2>;

/// Midpoints of the edges, and the longest squared length.
struct UpdateMidpoint {
  const EdgeEnds* edges;
  ConstVectorsView x;
  VectorsView midpoints;
  std::uint32_t* longest2;  // bit pattern

  TURGOR_HD void operator()(std::size_t e) const {
    const Vec3 a = x[std::size_t(edges[e][0])], b = x[std::size_t(edges[e][1])];
    midpoints.set(e, (a + b) * Real(0.5));
    atomic_max(*longest2, magnitude_bits(dot(b - a, b - a)));
  }
};

struct LargeTriangles {
  const Int3* list;
  std::size_t count;

  TURGOR_HD Range around(const LargeView& view, std::size_t n) const { return view.around(list[n]); }
};
struct LargeEdges {
  const EdgeEnds* list;
  std::size_t count;
  const std::uint32_t* longest2;  // bit pattern

  TURGOR_HD Real longest_half() const { return std::sqrt(std::bit_cast<Real>(*longest2)) / 2; }
  TURGOR_HD Range around(const LargeView& view, std::size_t n) const {
    return view.around(list[n], longest_half());
  }
};

/// Bounds of a block of triangles or edges.
template <class Items>
struct BoundBlock {
  LargeView view;
  Items items;
  Range* blocks;

  TURGOR_HD void operator()(std::size_t block) const {
    const std::size_t first = block * kLargeBlock;
    Range range = items.around(view, first);
    for (std::size_t n = first + 1; n < items.count && n < first + kLargeBlock; n++)
      range = joined(range, items.around(view, n));
    blocks[block] = range;
  }
};

/// Visits points near a primitive of a block in the host's order: if the block visits all points, so does the
/// primitive.
template <class Take>
TURGOR_HD inline void visit_of_block(const NearView& points, const Range& block, Vec3 low, Vec3 high,
                                     const Take& take) {
  if (points.is_all(block.low, block.high))
    points.visit(block.low, block.high, take);
  else
    points.visit(low, high, take);
}

struct FindTriangleContacts {
  LargeView view;
  LargeTriangles triangles;
  NearView vertices;
  const Range* blocks;
  ContactOutput output;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 t = triangles.list[n];
    const NearTriangle filter = view.filter(t);
    output(n, [&](const auto& take) {
      visit_of_block(vertices, blocks[n / kLargeBlock], filter.low, filter.high, [&](int v, Vec3 position) {
        Contact contact;
        if (filter.passes<Real>(position, view.at_rest(v)) && view.touch_triangle(n, v, contact))
          take(contact);
      });
    });
  }
};

struct FindEdgeContacts {
  LargeView view;
  LargeEdges edges;
  NearView midpoint_hash;
  const Range* blocks;
  ContactOutput output;

  TURGOR_HD void operator()(std::size_t n) const {
    const EdgeEnds ends = edges.list[n];
    if (!view.is_sharp(n)) return output(n, [](const auto&) {});
    const NearEdge filter = view.filter(ends, edges.longest_half());
    // edges near the block that pass the filter
    output(n, [&](const auto& take) {
      visit_of_block(midpoint_hash, blocks[n / kLargeBlock], filter.low, filter.high,
                     [&](int other, Vec3 middle) {
                       if (std::size_t(other) <= n) return;
                       const EdgeEnds others = edges.list[other];
                       const Vec3 rest_a = view.at_rest(others[0]), rest_b = view.at_rest(others[1]);
                       Contact contact;
                       if (filter.passes<Real>(middle, view.at(others[1]) - view.at(others[0]),
                                               (rest_a + rest_b) * Real(0.5), rest_b - rest_a) &&
                           view.touch_edges(n, std::size_t(other), contact))
                         take(contact);
                     });
    });
  }
};

template <class Backend>
class DeviceLargePrimitives {
 public:
  DeviceLargePrimitives(DeviceAllocator<Backend>& allocator, const Model& m)
      : triangles_(allocator.copy(m.large.triangles)),
        across_(allocator.copy(m.large.across)),
        edges_(allocator.copy(m.large.edges)),
        facing_(allocator.copy(m.large.facing)),
        star_begin_(allocator.copy(m.large.stars.begin)),
        star_item_(allocator.copy(m.large.stars.item)),
        midpoints_(allocator, m.large.edges.size()),
        midpoint_hash_(allocator, m.large.edges.size()),
        longest2_(allocator.template allocate<std::uint32_t>(m.large.edges.empty() ? 0 : 1)),
        blocks_(allocator.template allocate<Range>(block_count(triangles_) + block_count(edges_))),
        longest_(m.large.longest) {}

  /// Number of triangles and edges, each with a count of contacts.
  std::size_t count() const { return triangles_.size() + edges_.size(); }
  LargeMesh mesh() const { return {triangles_.data(), across_.data(), edges_.data(), facing_.data()}; }
  ConesView cones(ConstVectorsView x) const {
    return {x, star_begin_.size() > 0 ? star_begin_.data() : nullptr, star_item_.data()};
  }
  /// Updates bounds and midpoints.
  template <class Run>
  void update(const Run& run, const LargeView& large) {
    if (edges_.size() == 0) return;
    const std::uint32_t none = 0;
    longest2_.upload({&none, 1});
    run(edges_.size(), UpdateMidpoint{edges_.data(), large.x, view(midpoints_), longest2_.data()});
    midpoint_hash_view_ = midpoint_hash_.sort(run, view(midpoints_), longest_);
    run(block_count(triangles_), BoundBlock<LargeTriangles>{large, triangles(), blocks_.data()});
    run(block_count(edges_), BoundBlock<LargeEdges>{large, edges(), edge_blocks()});
  }
  template <class Run>
  void find(const Run& run, const LargeView& large, const NearView& vertices, ContactOutput output) const {
    run(triangles_.size(), FindTriangleContacts{large, triangles(), vertices, blocks_.data(), output});
    output.count += triangles_.size();
    run(edges_.size(), FindEdgeContacts{large, edges(), midpoint_hash_view_, edge_blocks(), output});
  }

 private:
  template <class Array>
  static std::size_t block_count(const Array& items) {
    return (items.size() + kLargeBlock - 1) / kLargeBlock;
  }
  LargeTriangles triangles() const { return {triangles_.data(), triangles_.size()}; }
  LargeEdges edges() const { return {edges_.data(), edges_.size(), longest2_.data()}; }
  Range* edge_blocks() const { return blocks_.data() + block_count(triangles_); }

  typename Backend::template Array<Int3> triangles_, across_;
  typename Backend::template Array<EdgeEnds> edges_, facing_;
  typename Backend::template Array<int> star_begin_, star_item_;
  DeviceVectors<Backend> midpoints_;
  DeviceSpatialHash<Backend> midpoint_hash_;
  NearView midpoint_hash_view_{};
  typename Backend::template Array<std::uint32_t> longest2_;
  typename Backend::template Array<Range> blocks_;  // of triangles, then of edges
  Real longest_;                                    // at rest [m]
};

}  // namespace turgor::cloth

// The deformed body alone as a CT, without cuts, as loops over plain pointers: a thread a node, a cell, a
// voxel. A voxel that several tetrahedra claim belongs to the first in lattice order, whichever comes first
// here: the same numbers as resample_ct. The same source runs on a CPU (CpuRun, ShuffledRun) and on a GPU; on
// a CPU resample_ct is faster, and knows cuts and what lies beside the body.
#pragma once

#include <utility>

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/lattice/ct_sampler.hpp"
#include "turgor/models/lattice/follow.hpp"
#include "turgor/models/lattice/rows.hpp"
#include "turgor/models/lattice/to_voxels.hpp"

namespace turgor::lattice {

/// How far nodes of tissue have moved, as bits of positive numbers: along each axis, and against it [m].
struct MovedBits {
  std::uint32_t along[3] = {}, against[3] = {};

  Vec3 high() const { return of(along); }
  Vec3 low() const { return -of(against); }
  static Vec3 of(const std::uint32_t (&bits)[3]) {
    return {std::bit_cast<Real>(bits[0]), std::bit_cast<Real>(bits[1]), std::bit_cast<Real>(bits[2])};
  }
};

/// A body without cuts on one side of the bus, and a grid for it.
struct ResampleView {
  Lattice lattice;
  NodeArrays nodes;
  MovedBits* moved;  // one
  ToVoxels to_voxels;
  RasterWindow window;
  RestFrame rest;
  Int3* place;           // by slot, where there is tissue or tissue beside [units]
  std::uint32_t* owner;  // by voxel: kNobody, or less the earlier a tetrahedron is
  Sampler sample;        // of the CT
  std::int16_t* out;     // by voxel [HU]

  static constexpr std::uint32_t kNobody = 0xffffffffu;

  TURGOR_HD bool is_solid(int slot) const { return nodes.root[slot] > 0; }
  TURGOR_HD Vec3 u(int slot) const { return nodes.u(slot); }
  TURGOR_HD bool is_parted(int, int, Int3) const { return false; }
  TURGOR_HD Int3 node(std::size_t n) const {
    const auto x = std::size_t(lattice.size.x), y = std::size_t(lattice.size.y);
    return {int(n % x), int(n / x % y), int(n / (x * y))};
  }
  TURGOR_HD std::size_t voxel_index(Int3 p) const {
    return (std::size_t(p.z) * std::size_t(window.high.y) + std::size_t(p.y)) * std::size_t(window.high.x) +
           std::size_t(p.x);
  }
  TURGOR_HD std::array<Int3, 4> corners(Int3 cell, const std::array<Int3, 4>& nodes_of_tet,
                                        bool& solid) const {
    const int slot = node_slot(lattice, cell), parity = cell.x & 1;
    std::array<Int3, 4> places;
    for (std::size_t n = 0; n < 4; n++) {
      const int corner = slot + slot_offset(lattice, nodes_of_tet[n], parity);
      places[n] = place[corner], solid |= is_solid(corner);
    }
    return places;
  }
};

struct FindMoved {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const int slot = node_slot(v.lattice, v.node(n));
    if (!v.is_solid(slot)) return;
    const Vec3 u = v.u(slot);
    for (int axis = 0; axis < 3; axis++) {
      std::uint32_t& most = u[axis] > 0 ? v.moved->along[axis] : v.moved->against[axis];
      atomic_max(most, magnitude_bits(u[axis]));
    }
  }
};

struct PlaceNode {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 node = v.node(n);
    const int slot = node_slot(v.lattice, node);
    if (v.is_solid(slot))
      v.place[slot] = v.to_voxels(node, v.u(slot));
    else if (is_beside_tissue(slot, node.x & 1))
      v.place[slot] = v.to_voxels(node, follow_neighbours(v.lattice, v, slot));
  }
  TURGOR_HD bool is_beside_tissue(int slot, int parity) const {
    bool found = false;
    for (int n = 0; n < 27; n++)
      if (const Int3 way = way_around(n); n != 13 && is_edge_way(way))
        found |= v.is_solid(slot + slot_offset(v.lattice, way, parity));
    return found;
  }
};

struct ForgetOwner {
  ResampleView v;
  TURGOR_HD void operator()(std::size_t voxel) const { v.owner[voxel] = ResampleView::kNobody; }
};

/// Claims the voxels of a cell's tetrahedra that are not turned inside out.
struct ClaimVoxels {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 cell = v.node(n), beyond = v.lattice.size - Int3{1, 1, 1};
    if (cell.x >= beyond.x || cell.y >= beyond.y || cell.z >= beyond.z) return;
    claim<0>(n, cell), claim<1>(n, cell), claim<2>(n, cell);
    claim<3>(n, cell), claim<4>(n, cell), claim<5>(n, cell);
  }
  template <int kTet>
  TURGOR_HD void claim(std::size_t n, Int3 cell) const {
    constexpr std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, kTet);
    bool solid = false;
    const std::array<Int3, 4> places = v.corners(cell, nodes, solid);
    if (!solid) return;
    const PlacedTet tet = place_tet<kTet>(places, v.window.handed);
    if (!(tet.det > 0)) return;
    visit_voxels<kTet>(tet, v.window, v.rest, cell, [&](Int3 voxel, Vec3) {
      atomic_min(v.owner[v.voxel_index(voxel)], std::uint32_t(6 * n + kTet));
    });
  }
};

/// Air, or what the CT has where the owner's tissue came from.
struct FillVoxel {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::uint32_t owner = v.owner[n];
    if (owner == ResampleView::kNobody) {
      v.out[n] = kAirHu;
      return;
    }
    const auto x = std::size_t(v.window.high.x), y = std::size_t(v.window.high.y);
    const Int3 voxel{int(n % x), int(n / x % y), int(n / (x * y))}, cell = v.node(owner / 6);
    const int tet = int(owner % 6);
    const Vec3 at = tet == 0   ? place<0>(cell, voxel)
                    : tet == 1 ? place<1>(cell, voxel)
                    : tet == 2 ? place<2>(cell, voxel)
                    : tet == 3 ? place<3>(cell, voxel)
                    : tet == 4 ? place<4>(cell, voxel)
                               : place<5>(cell, voxel);
    v.out[n] = to_hu(v.sample(at));
  }
  template <int kTet>
  TURGOR_HD Vec3 place(Int3 cell, Int3 voxel) const {
    constexpr std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, kTet);
    bool solid = false;
    const PlacedTet tet = place_tet<kTet>(v.corners(cell, nodes, solid), v.window.handed);
    return PlaceOfVoxel(tet, v.window.bits, v.rest, cell)(voxel);
  }
};

/// From nodes to voxels; FindMoved has gone before, and what it found has chosen the fixed point.
template <class Run>
void resample_with(const Run& run, const ResampleView& v) {
  const auto nodes = std::size_t(node_count(v.lattice));
  const Int3 size = v.window.high;
  const std::size_t voxels = std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
  run(nodes, PlaceNode{v});
  run(voxels, ForgetOwner{v});
  run(nodes, ClaimVoxels{v});
  run(voxels, FillVoxel{v});
}

}  // namespace turgor::lattice

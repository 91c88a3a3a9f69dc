// A body and a grid for its deformed CT, as plain pointers on one side of the bus, and what is counted on the
// way.
#pragma once

#include <bit>

#include "turgor/models/lattice/cutting/fragment_view.hpp"
#include "turgor/models/lattice/model/rows.hpp"
#include "turgor/models/lattice/resample/ct_sampler.hpp"
#include "turgor/models/lattice/resample/voxel_coordinates.hpp"

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

/// What cuts made of a body.
struct ResampleCuts {
  FragmentView pieces;
  int virtual_node_count, ghost_count;
  const SpecialCell* special;  // slots ascend
  int special_count;
  std::uint8_t* is_special;     // by slot of a cell's lowest node; null where no cell is
  const std::uint8_t* removed;  // by slot; null where nothing is
};

/// What is counted of a deformed CT. Many of these, each for some of the threads: one place of memory takes
/// few atomics a nanosecond.
struct ResampleCounts {
  std::uint64_t folds = 0, claims = 0, covered = 0;  // tetrahedra; voxels, by each that claims them; voxels
  std::uint64_t mass = 0;  // Σ HU + 1000 over the voxels of the body, as two's complement
};
constexpr std::size_t kCountParts = 256;

/// A body on one side of the bus, and a grid for it.
struct ResampleView {
  Lattice lattice;
  NodeArrays nodes;
  ResampleCuts cuts;
  MovedBits* moved;        // one
  ResampleCounts* counts;  // kCountParts
  bool conserve_mass;
  double to_ratio;  // volume now over volume in the CT = det · to_ratio
  VoxelCoordinates voxel_coordinates;
  RasterWindow window;
  RestFrame rest;
  Int3* place;           // by slot, where there is tissue or tissue beside, then of copies and guests [units]
  std::uint32_t* owner;  // by voxel: kNobody, or kClaims · number of the cell + claim, less the earlier; from
                         // kBeside on: partial_volume_kernels.hpp
  Sampler sample;     // of the CT
  std::int16_t* out;  // by voxel [HU]

  /// Claims are a whole cell's six tetrahedra, or 0 for whatever is in a special one.
  static constexpr std::uint32_t kNobody = 0xffffffffu, kBeside = 0x80000000u, kClaims = 6;

  TURGOR_HD bool is_solid(int slot) const {
    return nodes.root[slot] > 0 && (cuts.removed == nullptr || cuts.removed[slot] == 0);
  }
  TURGOR_HD Vec3 u(int slot) const { return nodes.u(slot); }
  TURGOR_HD bool is_parted(int beside, int behind, Int3 way) const {
    return lattice::is_parted(nodes.cut, lattice, beside, behind, way);
  }
  TURGOR_HD bool is_cut() const { return cuts.is_special != nullptr; }
  TURGOR_HD bool is_special(int slot) const { return is_cut() && cuts.is_special[slot] != 0; }
  TURGOR_HD Int3 node(std::size_t n) const {
    const auto x = std::size_t(lattice.size.x), y = std::size_t(lattice.size.y);
    return {int(n % x), int(n / x % y), int(n / (x * y))};
  }
  TURGOR_HD std::size_t voxel_index(Int3 p) const {
    return (std::size_t(p.z) * std::size_t(window.high.y) + std::size_t(p.y)) * std::size_t(window.high.x) +
           std::size_t(p.x);
  }
  TURGOR_HD ResampleCounts& count(std::size_t n) const { return counts[n % kCountParts]; }
  TURGOR_HD std::size_t voxel_count() const {
    return std::size_t(window.high.x) * std::size_t(window.high.y) * std::size_t(window.high.z);
  }
  TURGOR_HD Int3 voxel(std::size_t n) const {
    const auto x = std::size_t(window.high.x), y = std::size_t(window.high.y);
    return {int(n % x), int(n / x % y), int(n / (x * y))};
  }
  /// A whole cell's tetrahedron. Is there tissue at a corner?
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

}  // namespace turgor::lattice

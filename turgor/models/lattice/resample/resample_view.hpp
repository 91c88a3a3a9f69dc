// Body and output grid as plain pointers in host or device memory, and the counters of a resampling.
#pragma once

#include <bit>

#include "turgor/core/box_index.hpp"
#include "turgor/geometry/ct_sampler.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"
#include "turgor/models/lattice/model/rows.hpp"
#include "turgor/models/lattice/resample/voxel_coordinates.hpp"

namespace turgor::lattice {

/// Largest displacements of tissue nodes along each axis and against it, as bits of nonnegative floats [m].
struct MovedBits {
  std::uint32_t along[3] = {}, against[3] = {};

  Vec3 high() const { return of(along); }
  Vec3 low() const { return -of(against); }
  static Vec3 of(const std::uint32_t (&bits)[3]) {
    return {std::bit_cast<Real>(bits[0]), std::bit_cast<Real>(bits[1]), std::bit_cast<Real>(bits[2])};
  }
};

/// Cut topology of a body.
struct ResampleCuts {
  FragmentView fragments;
  int virtual_node_count, ghost_count;
  const SpecialCell* special;  // ascending slots
  int special_count;
  std::uint8_t* is_special;     // by slot of a cell's lowest node; null if no cell is special
  const std::uint8_t* removed;  // by slot; null if no node is removed
};

/// Counters of a resampling. Threads are spread over many of them, because atomics on one address are slow.
struct ResampleCounts {
  std::uint64_t inverted_tets = 0, claims = 0,
                covered = 0;  // inverted tetrahedra; claims of voxels; covered voxels
  std::uint64_t mass = 0;     // Σ (HU + 1000) over the voxels of the body, as two's complement
};
constexpr std::size_t kCounterCount = 256;

/// Body and output grid.
struct ResampleView {
  Lattice lattice;
  NodeArrays nodes;
  ResampleCuts cuts;
  MovedBits* moved;        // a single one
  ResampleCounts* counts;  // kCounterCount of them
  bool conserve_mass;
  double volume_scale;  // volume ratio, now over rest, = det · volume_scale
  VoxelCoordinates voxel_coordinates;
  RasterWindow window;
  RestFrame rest;
  Int3* position;  // by slot for tissue and adjacent air, then virtual nodes, then ghost corners [units]
  std::uint32_t* owner;  // by voxel: kUnclaimed, or the lowest kClaims · cell number + tetrahedron; values
                         // from kPartialVolume on are defined in partial_volume_kernels.hpp
  CtSampler sample;      // of the CT
  std::int16_t* out;     // by voxel [HU]

  /// Claims of a cell: one per tetrahedron of a whole cell; 0 for all of a special cell.
  static constexpr std::uint32_t kUnclaimed = 0xffffffffu, kPartialVolume = 0x80000000u, kClaims = 6;

  TURGOR_HD bool is_solid(int slot) const {
    return (nodes.root[slot] > 0 || nodes.w[slot] > 0) &&
           (cuts.removed == nullptr || cuts.removed[slot] == 0);
  }
  TURGOR_HD Vec3 u(int slot) const { return nodes.u(slot); }
  TURGOR_HD bool is_separated(int near, int far, Int3 offset) const {
    return lattice::is_separated(nodes.cut, lattice, near, far, offset);
  }
  TURGOR_HD bool is_cut() const { return cuts.is_special != nullptr; }
  TURGOR_HD bool is_special(int slot) const { return is_cut() && cuts.is_special[slot] != 0; }
  TURGOR_HD Int3 node(std::size_t n) const { return box_index(lattice.size, n); }
  TURGOR_HD std::size_t voxel_index(Int3 p) const {
    return (std::size_t(p.z) * std::size_t(window.high.y) + std::size_t(p.y)) * std::size_t(window.high.x) +
           std::size_t(p.x);
  }
  TURGOR_HD ResampleCounts& count(std::size_t n) const { return counts[n % kCounterCount]; }
  TURGOR_HD std::size_t voxel_count() const {
    return std::size_t(window.high.x) * std::size_t(window.high.y) * std::size_t(window.high.z);
  }
  TURGOR_HD Int3 voxel(std::size_t n) const { return box_index(window.high, n); }
  /// Voxel coordinates of a whole cell's tetrahedron.
  TURGOR_HD std::array<Int3, 4> corners(Int3 cell, const std::array<Int3, 4>& nodes_of_tet) const {
    const int slot = node_slot(lattice, cell), parity = cell.x & 1;
    std::array<Int3, 4> positions;
    for (std::size_t n = 0; n < 4; n++)
      positions[n] = position[slot + slot_offset(lattice, nodes_of_tet[n], parity)];
    return positions;
  }
};

}  // namespace turgor::lattice

// Deformed body in voxel coordinates, and the walk over its tetrahedra in a slab of voxel layers. The slabs
// are independent of the number of threads. Within a slab the order is that of the lattice, so results do not
// depend on the number of threads. Air nodes next to the body are displaced with it, so the outermost half
// cell of tissue is included.
#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/grid.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"
#include "turgor/models/lattice/resample/voxel_coordinates.hpp"

namespace turgor::lattice {

/// Kind of a cell: no tissue node at rest, plain, or special (several fragments or removed nodes).
enum class Cell : std::uint8_t { kEmpty, kPlain, kSpecial };

struct DeformedBody {
  const Model& model;
  const State& state;
  Fragments fragments;
  std::vector<std::uint8_t> solid;  // by slot: 1 = tissue now
  Grid out;
  RasterWindow window;  // all of `out`
  VoxelCoordinates voxel_coordinates;
  std::vector<Int3> position;  // voxel coordinates by slot for tissue and adjacent air, then virtual nodes,
                               // then ghost corners [units]
  std::vector<Cell> cells;     // by slot of the lowest corner
  struct Bounds {
    int low = std::numeric_limits<int>::max(), high = std::numeric_limits<int>::min();
  };
  std::vector<Bounds> rows;  // extent of rows of cells along k, j fastest [units]
};

DeformedBody deform_body(const Exec& exec, const Model& model, const State& state, const Grid& out);

constexpr int kVoxelLayers = 16;
inline int slab_count(const DeformedBody& body) {
  return (body.out.size.z + kVoxelLayers - 1) / kVoxelLayers;
}

namespace detail {

struct SlabWalk {
  const DeformedBody& body;
  const RestFrame& rest;
  RasterWindow window;
  int begin, end;       // slab along k [units]; open at the ends of the grid
  double volume_scale;  // volume ratio, now over rest, = det · volume_scale
  long inverted_tets = 0;
};

/// Visits the voxels of one deformed tetrahedron for which keep(rest position) is true. An inverted
/// tetrahedron is counted in the slab in which it begins.
template <int Tet, class Visit, class Keep>
void walk_deformed_tet(SlabWalk& walk, Int3 cell, const std::array<Int3, 4>& position, const Visit& visit,
                       const Keep& keep) {
  const DeformedTet tet = deform_tet<Tet>(position, walk.window.handedness);
  if (tet.high.z < walk.begin || tet.low.z >= walk.end) return;
  if (!(tet.det > 0)) {
    walk.inverted_tets += tet.low.z >= walk.begin;
    return;
  }
  const auto ratio = float(tet.det * walk.volume_scale);
  visit_voxels<Tet>(tet, walk.window, walk.rest, cell, [&](Int3 voxel, Vec3 at) {
    if (keep(at)) visit(cell, voxel, at, ratio);
  });
}

/// Visits one tetrahedron of a cell with the given corners; `keep` as above.
template <int Tet, class Visit, class Keep>
void walk_tet(SlabWalk& walk, Int3 cell, const std::array<int, 8>& slots, const std::array<int, 8>& corners,
              const Visit& visit, const Keep& keep) {
  constexpr auto nodes = kuhn_corners({0, 0, 0}, Tet);
  std::array<Int3, 4> position;
  bool solid = false;
  for (std::size_t n = 0; n < 4; n++) {
    const auto c = std::size_t(nodes[n].x + 2 * nodes[n].y + 4 * nodes[n].z);
    position[n] = walk.body.position[std::size_t(corners[c])];
    solid |= walk.body.solid[std::size_t(slots[c])] != 0;
  }
  if (solid) walk_deformed_tet<Tet>(walk, cell, position, visit, keep);
}

/// Visits a special cell. Every fragment and ghost covers the voxels that belong to it at rest.
template <class Visit>
void walk_special(SlabWalk& walk, Int3 cell, const std::array<int, 8>& slots, const Visit& visit) {
  const DeformedBody& body = walk.body;
  const CutCell* cut = find_cell(body.fragments, slots[0]);
  const FragmentView fragments = view(body.fragments, body.state.cuts, body.state.motion.virtual_u);
  FragmentFilter keep{.fragments = fragments,
                      .removed = body.state.cuts.removed_nodes > 0 ? body.state.cuts.removed.data() : nullptr,
                      .cut = cut,
                      .fragment = 0,
                      .first = walk.rest.first_node + hadamard(Vec3d(cell), walk.rest.cell_size),
                      .size = walk.rest.cell_size,
                      .slots = slots};
  const int count = cut ? cut->fragment_count + cut->ghost_count : 1;
  for (int fragment = 0; fragment < count; fragment++) {
    keep.fragment = fragment;
    const long inverted_tets = walk.inverted_tets;
    const auto corners = cut ? position_indices(fragments, *cut, fragment) : slots;
    [&]<std::size_t... T>(std::index_sequence<T...>) {
      (walk_tet<int(T)>(walk, cell, slots, corners, visit, keep), ...);
    }
    (std::make_index_sequence<6>());
    if (cut && fragment >= cut->fragment_count)
      walk.inverted_tets = inverted_tets;  // a ghost is no tissue of this cell
  }
}

template <class Visit>
void walk_cell(SlabWalk& walk, Int3 cell, const Visit& visit) {
  const Lattice& l = walk.body.model.lattice;
  const int parity = cell.x & 1, lower = node_slot(l, cell);
  const std::array<int, 8> slots = cell_slots(l, lower, parity);
  if (walk.body.cells[std::size_t(lower)] == Cell::kSpecial) return walk_special(walk, cell, slots, visit);
  const auto all = [](Vec3) { return true; };
  [&]<std::size_t... T>(std::index_sequence<T...>) {
    (walk_tet<int(T)>(walk, cell, slots, slots, visit, all), ...);
  }
  (std::make_index_sequence<6>());
}

}  // namespace detail

/// Calls visit(cell, voxel, rest position, volume ratio) for every voxel center of one slab that lies in
/// tissue. A center is visited once per tetrahedron that contains it, more than once only where the body
/// overlaps itself. Returns the number of inverted tetrahedra.
template <class Visit>
long walk_slab(const DeformedBody& body, int slab, const RestFrame& rest, const Visit& visit) {
  TURGOR_CHECK(is_index(slab, std::size_t(slab_count(body))), "the slab belongs to the output");
  const int layers = body.out.size.z, bits = body.window.bits;
  const int low = slab * kVoxelLayers, high = std::min(low + kVoxelLayers, layers);
  // range of the slab
  detail::SlabWalk walk{.body = body,
                        .rest = rest,
                        .window = body.window,
                        .begin = slab == 0 ? std::numeric_limits<int>::min() : low << bits,
                        .end = high == layers ? std::numeric_limits<int>::max() : high << bits,
                        .volume_scale = volume_ratio(body.model, body.out, bits)};
  walk.window.low.z = low, walk.window.high.z = high;
  // rows of cells that overlap it
  const Int3 size = body.model.lattice.size;
  for (int k = 0; k + 1 < size.z; k++)
    for (int j = 0; j + 1 < size.y; j++) {
      const DeformedBody::Bounds row = body.rows[std::size_t(k) * std::size_t(size.y - 1) + std::size_t(j)];
      if (row.low > row.high || row.high < walk.begin || row.low >= walk.end) continue;
      for (int i = 0; i + 1 < size.x; i++)
        if (body.cells[std::size_t(node_slot(body.model.lattice, i, j, k))] != Cell::kEmpty)
          detail::walk_cell(walk, {i, j, k}, visit);
    }
  return walk.inverted_tets;
}

}  // namespace turgor::lattice

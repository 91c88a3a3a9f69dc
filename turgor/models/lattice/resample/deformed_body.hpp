// Deformed body in voxel coordinates, and the walk over its tetrahedra in a slab of voxel layers. The slabs
// are independent of the number of threads. Within a slab the order is that of the lattice, so results do not
// depend on the number of threads. Air nodes next to the body are displaced with it, so the outermost half
// cell of tissue is included.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/grid.hpp"
#include "turgor/models/lattice/resample/tet_walk.hpp"
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

  bool is_solid(int slot) const { return solid[std::size_t(slot)] != 0; }
};

DeformedBody deform_body(const Exec& exec, const Model& model, const State& state, const Grid& out);

constexpr int kVoxelLayers = 16;
inline int slab_count(const DeformedBody& body) {
  return (body.out.size.z + kVoxelLayers - 1) / kVoxelLayers;
}

/// Visits the tetrahedra of one cell.
template <class Visit>
void walk_cell(TetWalk& walk, const DeformedBody& body, Int3 cell, const Visit& visit) {
  const Lattice& l = body.model.anatomy.lattice;
  const int lower = node_slot(l, cell);
  const std::array<int, 8> slots = cell_slots(l, lower, cell.x & 1);
  if (body.cells[std::size_t(lower)] != Cell::kSpecial)
    return walk_tets(walk, body, cell, slots, slots, visit, [](Vec3) { return true; });
  const Cuts& cuts = body.state.cuts;
  const FragmentView fragments = view(body.fragments, cuts, body.state.motion.virtual_u);
  walk_special_cell(walk, body, fragments, cuts.removed_nodes > 0 ? cuts.removed.data() : nullptr,
                    find_cell(body.fragments, lower), cell, slots, visit);
}

/// Calls visit(cell, voxel, rest position, volume ratio) for every voxel center of one slab that lies in
/// tissue. A center is visited once per tetrahedron that contains it, more than once only where the body
/// overlaps itself. Returns the number of inverted tetrahedra.
template <class Visit>
long walk_slab(const DeformedBody& body, int slab, const RestFrame& rest, const Visit& visit) {
  TURGOR_CHECK(is_index(slab, std::size_t(slab_count(body))), "the slab belongs to the output");
  const int layers = body.out.size.z, bits = body.window.bits;
  const int low = slab * kVoxelLayers, high = std::min(low + kVoxelLayers, layers);
  // range of the slab
  TetWalk walk{.window = body.window,
               .rest = rest,
               .volume_scale = volume_ratio(body.model, body.out, bits),
               .begin = slab == 0 ? std::numeric_limits<int>::min() : low << bits,
               .end = high == layers ? std::numeric_limits<int>::max() : high << bits};
  walk.window.low.z = low, walk.window.high.z = high;
  // rows of cells that overlap it
  const Int3 size = body.model.anatomy.lattice.size;
  for (int k = 0; k + 1 < size.z; k++)
    for (int j = 0; j + 1 < size.y; j++) {
      const DeformedBody::Bounds row = body.rows[std::size_t(k) * std::size_t(size.y - 1) + std::size_t(j)];
      if (row.low > row.high || row.high < walk.begin || row.low >= walk.end) continue;
      for (int i = 0; i + 1 < size.x; i++)
        if (body.cells[std::size_t(node_slot(body.model.anatomy.lattice, i, j, k))] != Cell::kEmpty)
          walk_cell(walk, body, {i, j, k}, [&](Int3 voxel, Vec3 at, float ratio) {
            visit(Int3{i, j, k}, voxel, at, ratio);
          });
    }
  return walk.inverted_tets;
}

}  // namespace turgor::lattice

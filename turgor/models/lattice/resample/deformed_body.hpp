// A deformed body among the voxels of a grid: where every node lies, which cells hold tissue, which of them
// need care near a cut; and the walk over all tetrahedra of a slab of voxel layers. Slabs are independent and
// always the same, and within one the order is the lattice's, so that results do not depend on the number of
// threads. Air nodes beside the body follow it, so that the outermost half step of tissue is not lost.
#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "turgor/geometry/grid.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"
#include "turgor/models/lattice/resample/voxel_coordinates.hpp"

namespace turgor::lattice {

/// Whether a cell has a node of tissue in the CT; special: in pieces, or with removed nodes.
enum class Cell : std::uint8_t { kEmpty, kPlain, kSpecial };

struct DeformedBody {
  const Model& model;
  const State& state;
  Fragments pieces;
  std::vector<std::uint8_t> solid;  // by slot: 1 = tissue now
  Grid out;
  RasterWindow window;  // all of `out`
  VoxelCoordinates voxel_coordinates;
  std::vector<Int3>
      place;  // by slot, where there is tissue or tissue beside, then of copies and guests [units]
  std::vector<Cell> cells;  // by slot of the lower corner
  struct Bounds {
    int low = std::numeric_limits<int>::max(), high = std::numeric_limits<int>::min();
  };
  std::vector<Bounds> rows;  // of cells, j fastest: along k [units]
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
  int begin, end;   // the slab along k [units]; open at the ends of the grid
  double to_ratio;  // volume now over volume in the CT = det · to_ratio
  long folds = 0;
};

/// Visits one placed tetrahedron; `keep(place)` chooses among its voxels. A fold is counted in the slab where
/// it begins.
template <int Tet, class Visit, class Keep>
void walk_placed(SlabWalk& walk, Int3 cell, const std::array<Int3, 4>& place, const Visit& visit,
                 const Keep& keep) {
  const DeformedTet tet = deform_tet<Tet>(place, walk.window.handed);
  if (tet.high.z < walk.begin || tet.low.z >= walk.end) return;
  if (!(tet.det > 0)) {
    walk.folds += tet.low.z >= walk.begin;
    return;
  }
  const auto ratio = float(tet.det * walk.to_ratio);
  visit_voxels<Tet>(tet, walk.window, walk.rest, cell, [&](Int3 voxel, Vec3 at) {
    if (keep(at)) visit(cell, voxel, at, ratio);
  });
}

/// One tetrahedron of a cell whose corners are these; `keep` as above.
template <int Tet, class Visit, class Keep>
void walk_tet(SlabWalk& walk, Int3 cell, const std::array<int, 8>& slots, const std::array<int, 8>& corners,
              const Visit& visit, const Keep& keep) {
  constexpr auto nodes = kuhn_corners({0, 0, 0}, Tet);
  std::array<Int3, 4> place;
  bool solid = false;
  for (std::size_t n = 0; n < 4; n++) {
    const auto c = std::size_t(nodes[n].x + 2 * nodes[n].y + 4 * nodes[n].z);
    place[n] = walk.body.place[std::size_t(corners[c])];
    solid |= walk.body.solid[std::size_t(slots[c])] != 0;
  }
  if (solid) walk_placed<Tet>(walk, cell, place, visit, keep);
}

/// Every piece, and every guest, carries the voxels that lay in it.
template <class Visit>
void walk_special(SlabWalk& walk, Int3 cell, const std::array<int, 8>& slots, const Visit& visit) {
  const DeformedBody& body = walk.body;
  const CutCell* cut = find_cell(body.pieces, slots[0]);
  const FragmentView pieces = view(body.pieces, body.state);
  TissueOfFragment keep{.pieces = pieces,
                        .removed = body.state.removed_nodes > 0 ? body.state.removed.data() : nullptr,
                        .cut = cut,
                        .piece = 0,
                        .first = walk.rest.first_node + hadamard(Vec3d(cell), walk.rest.cell_size),
                        .size = walk.rest.cell_size,
                        .slots = slots};
  const int count = cut ? cut->fragment_count + cut->ghost_count : 1;
  for (int piece = 0; piece < count; piece++) {
    keep.piece = piece;
    const long folds = walk.folds;
    const auto corners = cut ? placed_corners(pieces, *cut, piece) : slots;
    [&]<std::size_t... T>(std::index_sequence<T...>) {
      (walk_tet<int(T)>(walk, cell, slots, corners, visit, keep), ...);
    }
    (std::make_index_sequence<6>());
    if (cut && piece >= cut->fragment_count) walk.folds = folds;  // no tissue of this cell
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

/// Calls visit(cell, voxel, place in the CT, volume ratio) for every voxel centre of one slab that lies in
/// tissue, once for every tetrahedron it lies in: once, but where the body folds over itself. Returns the
/// number of tetrahedra turned inside out.
template <class Visit>
long walk_slab(const DeformedBody& body, int slab, const RestFrame& rest, const Visit& visit) {
  const int layers = body.out.size.z, bits = body.window.bits;
  const int low = slab * kVoxelLayers, high = std::min(low + kVoxelLayers, layers);
  detail::SlabWalk walk{.body = body,
                        .rest = rest,
                        .window = body.window,
                        .begin = slab == 0 ? std::numeric_limits<int>::min() : low << bits,
                        .end = high == layers ? std::numeric_limits<int>::max() : high << bits,
                        .to_ratio = volume_ratio(body.model, body.out, bits)};
  walk.window.low.z = low, walk.window.high.z = high;
  const Int3 size = body.model.lattice.size;
  for (int k = 0; k + 1 < size.z; k++)
    for (int j = 0; j + 1 < size.y; j++) {
      const DeformedBody::Bounds row = body.rows[std::size_t(k) * std::size_t(size.y - 1) + std::size_t(j)];
      if (row.low > row.high || row.high < walk.begin || row.low >= walk.end) continue;
      for (int i = 0; i + 1 < size.x; i++)
        if (body.cells[std::size_t(node_slot(body.model.lattice, i, j, k))] != Cell::kEmpty)
          detail::walk_cell(walk, {i, j, k}, visit);
    }
  return walk.folds;
}

}  // namespace turgor::lattice

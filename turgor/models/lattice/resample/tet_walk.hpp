// Walk over the voxels of deformed tetrahedra, for a slab of voxel layers on the host (deformed_body.hpp) and
// for one cell per GPU thread (resample_kernels.hpp). A `Body` has is_solid(slot) and, in `position`, the
// voxel coordinates of nodes, virtual nodes and ghost corners.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "turgor/geometry/ct_sampler.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

struct TetWalk {
  RasterWindow window;
  const RestFrame& rest;
  double volume_scale;  // volume ratio, now over rest, = det · volume_scale
  // range along k in which tetrahedra are visited [units]
  int begin = std::numeric_limits<int>::min(), end = std::numeric_limits<int>::max();
  std::uint32_t inverted_tets = 0;
};

/// Calls visit(voxel, rest position, volume ratio) for the voxels of one deformed tetrahedron for which
/// keep(rest position) is true. An inverted tetrahedron is counted in the range in which it begins.
template <int kTet, class Visit, class Keep>
TURGOR_HD void walk_tet(TetWalk& walk, Int3 cell, const std::array<Int3, 4>& position, const Visit& visit,
                        const Keep& keep) {
  const DeformedTet tet = deform_tet<kTet>(position, walk.window.handedness);
  if (tet.high.z < walk.begin || tet.low.z >= walk.end) return;
  if (!(tet.det > 0)) {
    walk.inverted_tets += tet.low.z >= walk.begin;
    return;
  }
  const auto ratio = float(tet.det * walk.volume_scale);
  visit_voxels<kTet>(tet, walk.window, walk.rest, cell, [&](Int3 voxel, Vec3 at) {
    if (keep(at)) visit(voxel, at, ratio);
  });
}

/// Visits one tetrahedron of a cell, if one of its nodes is tissue. `slots`: of the cell's nodes; `corners`:
/// indices of positions.
template <int kTet, class Body, class Visit, class Keep>
TURGOR_HD void walk_tet_of_cell(TetWalk& walk, const Body& body, Int3 cell, const std::array<int, 8>& slots,
                                const std::array<int, 8>& corners, const Visit& visit, const Keep& keep) {
  constexpr std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, kTet);
  std::array<Int3, 4> position;
  bool solid = false;
  TURGOR_UNROLL
  for (std::size_t n = 0; n < 4; n++) {
    const auto c = std::size_t(nodes[n].x + 2 * nodes[n].y + 4 * nodes[n].z);
    position[n] = body.position[std::size_t(corners[c])];
    solid |= body.is_solid(slots[c]);
  }
  if (solid) walk_tet<kTet>(walk, cell, position, visit, keep);
}
/// Visits all six tetrahedra of a cell.
template <class Body, class Visit, class Keep>
TURGOR_HD void walk_tets(TetWalk& walk, const Body& body, Int3 cell, const std::array<int, 8>& slots,
                         const std::array<int, 8>& corners, const Visit& visit, const Keep& keep) {
  walk_tet_of_cell<0>(walk, body, cell, slots, corners, visit, keep);
  walk_tet_of_cell<1>(walk, body, cell, slots, corners, visit, keep);
  walk_tet_of_cell<2>(walk, body, cell, slots, corners, visit, keep);
  walk_tet_of_cell<3>(walk, body, cell, slots, corners, visit, keep);
  walk_tet_of_cell<4>(walk, body, cell, slots, corners, visit, keep);
  walk_tet_of_cell<5>(walk, body, cell, slots, corners, visit, keep);
}

/// Visits a special cell. Every fragment and ghost covers the voxels that belong to it at rest. `removed`:
/// Cuts::removed, or null; `cut`: null if the cell has a single fragment.
template <class Body, class Visit>
TURGOR_HD void walk_special_cell(TetWalk& walk, const Body& body, const FragmentView& fragments,
                                 const std::uint8_t* removed, const CutCell* cut, Int3 cell,
                                 const std::array<int, 8>& slots, const Visit& visit) {
  FragmentFilter keep{.fragments = fragments,
                      .removed = removed,
                      .cut = cut,
                      .fragment = 0,
                      .first = walk.rest.first_node + hadamard(Vec3d(cell), walk.rest.cell_size),
                      .size = walk.rest.cell_size,
                      .slots = slots};
  const int count = cut ? cut->fragment_count + cut->ghost_count : 1;
  for (int fragment = 0; fragment < count; fragment++) {
    if (cut && is_excised(fragments, *cut, fragment)) continue;
    keep.fragment = fragment;
    const std::uint32_t inverted_before = walk.inverted_tets;
    const std::array<int, 8> corners = cut ? position_indices(fragments, *cut, fragment) : slots;
    walk_tets(walk, body, cell, slots, corners, visit, keep);
    if (cut && fragment >= cut->fragment_count)
      walk.inverted_tets = inverted_before;  // a ghost is no tissue of this cell
  }
}

/// True if a neighbor along an edge is tissue.
template <class Body>
TURGOR_HD bool is_beside_tissue(const Lattice& l, const Body& body, int slot, int parity) {
  bool found = false;
  for (int n = 0; n < 27; n++)
    if (const Int3 offset = box_offset(n); n != 13 && is_edge_offset(offset))
      found |= body.is_solid(slot + slot_offset(l, offset, parity));
  return found;
}

/// Value of tissue in the deformed CT; the mass is conserved by the volume ratio [HU].
TURGOR_HD inline std::int16_t deformed_hu(float value, float ratio, bool conserve_mass) {
  return round_to_hu(conserve_mass ? (value - kAirHu) / ratio + kAirHu : value);
}

}  // namespace turgor::lattice

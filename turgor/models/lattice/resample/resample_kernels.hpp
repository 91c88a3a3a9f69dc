// Kernels that resample the deformed body: one thread per node, cell or voxel, over the pointers of
// resample_view.hpp. A voxel claimed by several tetrahedra belongs to the first in lattice order, independent
// of execution order. So the numbers equal those of resample_ct. The same source runs on the host (CpuRun,
// ShuffledRun) and on a GPU; on the host, resample_ct is faster. Voxels outside the body are in
// partial_volume_kernels.hpp.
#pragma once

#include <algorithm>
#include <utility>

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/lattice/resample/resample_view.hpp"
#include "turgor/models/lattice/resample/tet_walk.hpp"

namespace turgor::lattice {

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

struct LocateNode {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 node = v.node(n);
    const int slot = node_slot(v.lattice, node);
    if (v.is_solid(slot))
      v.position[slot] = v.voxel_coordinates(node, v.u(slot));
    else if (is_beside_tissue(v.lattice, v, slot, node.x & 1))
      v.position[slot] = v.voxel_coordinates(node, extrapolate_from_neighbors(v.lattice, v, slot));
  }
};

struct ClearOwner {
  ResampleView v;
  TURGOR_HD void operator()(std::size_t voxel) const { v.owner[voxel] = ResampleView::kUnclaimed; }
};

struct LocateVirtualNode {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const int corner = slot_count(v.lattice) + int(n);
    v.position[corner] = v.voxel_coordinates(slot_node(v.lattice, v.cuts.fragments.virtual_nodes[n].slot),
                                             corner_displacement(v, v.cuts.fragments, corner));
  }
};

struct LocateGhostFragment {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const FragmentView& fragments = v.cuts.fragments;
    const int ghost = int(n / 8), c = int(n % 8);
    v.position[std::size_t(fragments.first_ghost_position) + n] =
        v.voxel_coordinates(slot_node(v.lattice, fragments.ghosts[ghost].slot) + cell_corner(c),
                            ghost_displacement(v, fragments, ghost, c));
  }
};

struct ClearSpecial {
  ResampleView v;
  TURGOR_HD void operator()(std::size_t slot) const { v.cuts.is_special[slot] = 0; }
};
struct MarkSpecial {
  ResampleView v;
  TURGOR_HD void operator()(std::size_t n) const { v.cuts.is_special[v.cuts.special[n].slot] = 1; }
};

/// Counts of one cell.
struct ClaimCounts {
  std::uint32_t inverted_tets = 0, claims = 0;

  TURGOR_HD void add_to(ResampleCounts& counts) const {
    if (inverted_tets > 0) atomic_add(counts.inverted_tets, inverted_tets);
    if (claims > 0) atomic_add(counts.claims, claims);
  }
};

/// Claims the voxels of a whole cell's tetrahedra, except inverted ones.
struct ClaimVoxels {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 cell = v.node(n), beyond = v.lattice.size - Int3{1, 1, 1};
    if (cell.x >= beyond.x || cell.y >= beyond.y || cell.z >= beyond.z) return;
    const int slot = node_slot(v.lattice, cell);
    if (v.is_special(slot)) return;
    const std::array<int, 8> slots = cell_slots(v.lattice, slot, cell.x & 1);
    ClaimCounts counts;
    claim<0>(n, cell, slots, counts), claim<1>(n, cell, slots, counts), claim<2>(n, cell, slots, counts);
    claim<3>(n, cell, slots, counts), claim<4>(n, cell, slots, counts), claim<5>(n, cell, slots, counts);
    counts.add_to(v.count(n));
  }
  /// The lowest claim owns a voxel.
  template <int kTet>
  TURGOR_HD void claim(std::size_t n, Int3 cell, const std::array<int, 8>& slots, ClaimCounts& counts) const {
    TetWalk walk{v.window, v.rest, v.volume_scale};
    const auto visit = [&](Int3 voxel, Vec3, float) {
      counts.claims++;
      atomic_min(v.owner[v.voxel_index(voxel)], std::uint32_t(ResampleView::kClaims * n + kTet));
    };
    walk_tet_of_cell<kTet>(walk, v, cell, slots, slots, visit, [](Vec3) { return true; });
    counts.inverted_tets += walk.inverted_tets;
  }
};

/// Calls visit(voxel, rest position, volume ratio) for the voxels of a window covered by the fragments of a
/// special cell. The order is by fragment, then by tetrahedron. Returns the number of inverted tetrahedra.
template <class Visit>
TURGOR_HD std::uint32_t walk_special_cell(const ResampleView& v, const RasterWindow& window,
                                          const SpecialCell& special, const Visit& visit) {
  const Int3 cell = slot_node(v.lattice, special.slot);
  const FragmentView& fragments = v.cuts.fragments;
  TetWalk walk{window, v.rest, v.volume_scale};
  walk_special_cell(walk, v, fragments, v.cuts.removed,
                    special.cut < 0 ? nullptr : &fragments.cells[special.cut], cell,
                    cell_slots(v.lattice, special.slot, cell.x & 1), visit);
  return walk.inverted_tets;
}

struct ClaimSpecial {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 cell = slot_node(v.lattice, v.cuts.special[n].slot), size = v.lattice.size;
    const std::size_t number =
        (std::size_t(cell.z) * std::size_t(size.y) + std::size_t(cell.y)) * std::size_t(size.x) +
        std::size_t(cell.x);
    ClaimCounts counts;
    counts.inverted_tets = walk_special_cell(v, v.window, v.cuts.special[n], [&](Int3 voxel, Vec3, float) {
      counts.claims++;
      atomic_min(v.owner[v.voxel_index(voxel)], std::uint32_t(ResampleView::kClaims * number));
    });
    counts.add_to(v.count(n));
  }
};

/// Rest position and volume ratio of a voxel's tissue.
struct TissueAt {
  Vec3 rest;        // rest position [voxels of the CT]
  float ratio = 1;  // volume ratio, deformed over rest
};
/// Voxels of whole cells and of special cells are filled by separate kernels, because special cells need
/// three times the registers.
enum class Cells { kWhole, kSpecial };
template <Cells kCells>
struct FindTissue {
  const ResampleView& v;

  /// True if this kernel fills the voxels of an owner.
  TURGOR_HD bool has(std::uint32_t owner) const {
    const bool is_special = v.is_special(node_slot(v.lattice, v.node(owner / ResampleView::kClaims)));
    return is_special == (kCells == Cells::kSpecial);
  }
  TURGOR_HD TissueAt operator()(std::uint32_t owner, Int3 voxel) const {
    const Int3 cell = v.node(owner / ResampleView::kClaims);
    if constexpr (kCells == Cells::kSpecial) return locate_in_special(node_slot(v.lattice, cell), voxel);
    const int tet = int(owner % ResampleView::kClaims);
    return tet == 0   ? locate<0>(cell, voxel)
           : tet == 1 ? locate<1>(cell, voxel)
           : tet == 2 ? locate<2>(cell, voxel)
           : tet == 3 ? locate<3>(cell, voxel)
           : tet == 4 ? locate<4>(cell, voxel)
                      : locate<5>(cell, voxel);
  }
  /// Rest position in a special cell, from the first tetrahedron that contains the voxel.
  TURGOR_HD TissueAt locate_in_special(int slot, Int3 voxel) const {
    // binary search for the cell
    int low = 0, high = v.cuts.special_count - 1;
    while (low < high) {
      const int middle = (low + high) / 2;
      if (v.cuts.special[middle].slot < slot)
        low = middle + 1;
      else
        high = middle;
    }
    RasterWindow one = v.window;
    // walk restricted to this voxel
    one.low = voxel, one.high = voxel + Int3{1, 1, 1};
    TissueAt found;
    bool is_found = false;
    walk_special_cell(v, one, v.cuts.special[low], [&](Int3, Vec3 at, float ratio) {
      if (!is_found) found = {at, ratio};
      is_found = true;
    });
    return found;
  }
  template <int kTet>
  TURGOR_HD TissueAt locate(Int3 cell, Int3 voxel) const {
    constexpr std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, kTet);
    const DeformedTet tet = deform_tet<kTet>(v.corners(cell, nodes), v.window.handedness);
    return {VoxelToRest(tet, v.window.bits, v.rest, cell)(voxel), float(tet.det * v.volume_scale)};
  }
};

/// Writes the CT's value at the rest position, or air for voxels without an owner.
template <Cells kCells>
struct FillVoxel {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::uint32_t owner = v.owner[n];
    if (owner >= ResampleView::kPartialVolume) {
      if (kCells == Cells::kWhole) v.out[n] = kAirHu;
    } else if (const FindTissue<kCells> find{v}; find.has(owner)) {
      v.out[n] = value(find(owner, v.voxel(n)));
    }
  }
  TURGOR_HD std::int16_t value(TissueAt tissue) const {
    return deformed_hu(v.sample(tissue.rest), tissue.ratio, v.conserve_mass);
  }
};

/// Writes a field of deformed_fields.hpp.
template <Cells kCells, class Of, class Sample>
struct FillField : Of {
  ResampleView v;
  Sample* field;  // by voxel

  TURGOR_HD void operator()(std::size_t n) const {
    const std::uint32_t owner = v.owner[n];
    if (owner >= ResampleView::kPartialVolume) {
      if (kCells == Cells::kWhole) field[n] = Of::outside();
    } else if (const FindTissue<kCells> find{v}; find.has(owner)) {
      const Int3 voxel = v.voxel(n);
      const TissueAt tissue = find(owner, voxel);
      field[n] = Of::operator()(voxel, tissue.rest, tissue.ratio);
    }
  }
};
template <class Run, class Of, class Sample>
void fill_field_with(const Run& run, const ResampleView& v, const Of& of, Sample* field) {
  run(v.voxel_count(), FillField<Cells::kWhole, Of, Sample>{of, v, field});
  if (v.is_cut()) run(v.voxel_count(), FillField<Cells::kSpecial, Of, Sample>{of, v, field});
}

/// Counts covered voxels and mass. Threads take every kThreads-th voxel, so that neighbors in memory are read
/// at once.
struct CountTissue {
  ResampleView v;

  static constexpr std::size_t kThreads = std::size_t(1) << 18;

  TURGOR_HD void operator()(std::size_t thread) const {
    std::uint32_t covered = 0;
    std::int64_t mass = 0;
    for (std::size_t n = thread, end = v.voxel_count(); n < end; n += kThreads) {
      if (v.owner[n] >= ResampleView::kPartialVolume) continue;
      covered++, mass += v.out[n] - kAirHu;
    }
    if (covered == 0) return;
    atomic_add(v.count(thread).covered, covered), atomic_add(v.count(thread).mass, std::uint64_t(mass));
  }
};

/// Runs the kernels from node positions to the owners of voxels. FindMoved must have run before, to choose
/// the fixed point.
template <class Run>
void claim_with(const Run& run, const ResampleView& v) {
  const auto nodes = std::size_t(node_count(v.lattice));
  run(nodes, LocateNode{v});
  run(std::size_t(v.cuts.virtual_node_count), LocateVirtualNode{v});
  run(std::size_t(8 * v.cuts.ghost_count), LocateGhostFragment{v});
  if (v.is_cut()) {
    run(std::size_t(slot_count(v.lattice)), ClearSpecial{v});
    run(std::size_t(v.cuts.special_count), MarkSpecial{v});
  }
  run(v.voxel_count(), ClearOwner{v});
  run(nodes, ClaimVoxels{v});
  run(std::size_t(v.cuts.special_count), ClaimSpecial{v});
}
/// Runs all kernels up to HU.
template <class Run>
void resample_with(const Run& run, const ResampleView& v) {
  claim_with(run, v);
  run(v.voxel_count(), FillVoxel<Cells::kWhole>{v});
  if (v.is_cut()) run(v.voxel_count(), FillVoxel<Cells::kSpecial>{v});
  run(std::min(v.voxel_count(), CountTissue::kThreads), CountTissue{v});
}

}  // namespace turgor::lattice

// The deformed body as a CT, as loops over plain pointers (resample_view.hpp): a thread a node, a cell, a
// voxel. A voxel that several tetrahedra claim belongs to the first in lattice order, whichever comes first
// here: the same numbers as resample_ct. The same source runs on a CPU (CpuRun, ShuffledRun) and on a GPU; on
// a CPU resample_ct is faster. So it is with the fields of deformed_fields.hpp. What lies beside the body is
// in partial_volume_kernels.hpp.
#pragma once

#include <utility>

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/lattice/resample/resample_view.hpp"

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

struct PlaceNode {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 node = v.node(n);
    const int slot = node_slot(v.lattice, node);
    if (v.is_solid(slot))
      v.place[slot] = v.voxel_coordinates(node, v.u(slot));
    else if (is_beside_tissue(slot, node.x & 1))
      v.place[slot] = v.voxel_coordinates(node, extrapolate_from_neighbors(v.lattice, v, slot));
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

struct PlaceCopy {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const int corner = slot_count(v.lattice) + int(n);
    v.place[corner] = v.voxel_coordinates(slot_node(v.lattice, v.cuts.pieces.virtual_nodes[n].slot),
                                          corner_displacement(v, v.cuts.pieces, corner));
  }
};

struct PlaceGhostFragment {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const FragmentView& pieces = v.cuts.pieces;
    const int ghost = int(n / 8), c = int(n % 8);
    v.place[std::size_t(pieces.first_ghost_place) + n] =
        v.voxel_coordinates(slot_node(v.lattice, pieces.ghosts[ghost].slot) + cell_corner(c),
                            ghost_displacement(v, pieces, ghost, c));
  }
};

struct ForgetSpecial {
  ResampleView v;
  TURGOR_HD void operator()(std::size_t slot) const { v.cuts.is_special[slot] = 0; }
};
struct MarkSpecial {
  ResampleView v;
  TURGOR_HD void operator()(std::size_t n) const { v.cuts.is_special[v.cuts.special[n].slot] = 1; }
};

/// Of one cell.
struct ClaimCounts {
  std::uint32_t folds = 0, claims = 0;

  TURGOR_HD void add_to(ResampleCounts& counts) const {
    if (folds > 0) atomic_add(counts.folds, folds);
    if (claims > 0) atomic_add(counts.claims, claims);
  }
};

/// Claims the voxels of a whole cell's tetrahedra that are not turned inside out.
struct ClaimVoxels {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 cell = v.node(n), beyond = v.lattice.size - Int3{1, 1, 1};
    if (cell.x >= beyond.x || cell.y >= beyond.y || cell.z >= beyond.z) return;
    if (v.is_special(node_slot(v.lattice, cell))) return;
    ClaimCounts counts;
    claim<0>(n, cell, counts), claim<1>(n, cell, counts), claim<2>(n, cell, counts);
    claim<3>(n, cell, counts), claim<4>(n, cell, counts), claim<5>(n, cell, counts);
    counts.add_to(v.count(n));
  }
  template <int kTet>
  TURGOR_HD void claim(std::size_t n, Int3 cell, ClaimCounts& counts) const {
    constexpr std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, kTet);
    bool solid = false;
    const std::array<Int3, 4> places = v.corners(cell, nodes, solid);
    if (!solid) return;
    const DeformedTet tet = deform_tet<kTet>(places, v.window.handed);
    if (!(tet.det > 0)) {
      counts.folds++;
      return;
    }
    visit_voxels<kTet>(tet, v.window, v.rest, cell, [&](Int3 voxel, Vec3) {
      counts.claims++;
      atomic_min(v.owner[v.voxel_index(voxel)], std::uint32_t(ResampleView::kClaims * n + kTet));
    });
  }
};

/// Calls visit(voxel, place in the CT, volume ratio) for the voxels of a window that the pieces of a special
/// cell carry, piece by piece and tetrahedron by tetrahedron.
template <class Visit>
struct WalkSpecial {
  const ResampleView& v;
  RasterWindow window;
  const Visit& visit;
  std::uint32_t folds = 0;

  TURGOR_HD void operator()(const SpecialCell& special) {
    const Int3 cell = slot_node(v.lattice, special.slot);
    const std::array<int, 8> slots = cell_slots(v.lattice, special.slot, cell.x & 1);
    const FragmentView& pieces = v.cuts.pieces;
    const CutCell* cut = special.cut < 0 ? nullptr : &pieces.cells[special.cut];
    TissueOfFragment keep{.pieces = pieces,
                          .removed = v.cuts.removed,
                          .cut = cut,
                          .piece = 0,
                          .first = v.rest.first_node + hadamard(Vec3d(cell), v.rest.cell_size),
                          .size = v.rest.cell_size,
                          .slots = slots};
    const int count = cut ? cut->fragment_count + cut->ghost_count : 1;
    for (int p = 0; p < count; p++) {
      keep.piece = p;
      const std::uint32_t folds_before = folds;
      const std::array<int, 8> corners = cut ? placed_corners(pieces, *cut, p) : slots;
      walk<0>(cell, slots, corners, keep), walk<1>(cell, slots, corners, keep);
      walk<2>(cell, slots, corners, keep), walk<3>(cell, slots, corners, keep);
      walk<4>(cell, slots, corners, keep), walk<5>(cell, slots, corners, keep);
      if (cut && p >= cut->fragment_count) folds = folds_before;  // no tissue of this cell
    }
  }
  template <int kTet>
  TURGOR_HD void walk(Int3 cell, const std::array<int, 8>& slots, const std::array<int, 8>& corners,
                      const TissueOfFragment& keep) {
    constexpr std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, kTet);
    constexpr std::size_t at[4] = {0, std::size_t(nodes[1].x + 2 * nodes[1].y + 4 * nodes[1].z),
                                   std::size_t(nodes[2].x + 2 * nodes[2].y + 4 * nodes[2].z), 7};
    if (!v.is_solid(slots[at[0]]) && !v.is_solid(slots[at[1]]) && !v.is_solid(slots[at[2]]) &&
        !v.is_solid(slots[at[3]]))
      return;
    const DeformedTet tet = deform_tet<kTet>(
        {v.place[corners[at[0]]], v.place[corners[at[1]]], v.place[corners[at[2]]], v.place[corners[at[3]]]},
        window.handed);
    if (!(tet.det > 0)) {
      folds++;
      return;
    }
    const auto ratio = float(tet.det * v.to_ratio);
    visit_voxels<kTet>(tet, window, v.rest, cell, [&](Int3 voxel, Vec3 place) {
      if (keep(place)) visit(voxel, place, ratio);
    });
  }
};
/// Returns the number of tetrahedra turned inside out.
template <class Visit>
TURGOR_HD std::uint32_t walk_special_cell(const ResampleView& v, const RasterWindow& window,
                                          const SpecialCell& special, const Visit& visit) {
  WalkSpecial<Visit> walk{v, window, visit};
  walk(special);
  return walk.folds;
}

struct ClaimSpecial {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 cell = slot_node(v.lattice, v.cuts.special[n].slot), size = v.lattice.size;
    const std::size_t number =
        (std::size_t(cell.z) * std::size_t(size.y) + std::size_t(cell.y)) * std::size_t(size.x) +
        std::size_t(cell.x);
    ClaimCounts counts;
    counts.folds = walk_special_cell(v, v.window, v.cuts.special[n], [&](Int3 voxel, Vec3, float) {
      counts.claims++;
      atomic_min(v.owner[v.voxel_index(voxel)], std::uint32_t(ResampleView::kClaims * number));
    });
    counts.add_to(v.count(n));
  }
};

/// Where a voxel's tissue came from.
struct TissueAt {
  Vec3 place;       // in the CT [voxels]
  float ratio = 1;  // volume now over volume in the CT
};
/// Voxels of cells that no blade parted and of special ones are filled one after the other: what the latter
/// ask for takes three times the registers.
enum class Cells { kWhole, kSpecial };
template <Cells kCells>
struct FindTissue {
  const ResampleView& v;

  /// Or nothing of this owner.
  TURGOR_HD bool has(std::uint32_t owner) const {
    const bool is_special = v.is_special(node_slot(v.lattice, v.node(owner / ResampleView::kClaims)));
    return is_special == (kCells == Cells::kSpecial);
  }
  TURGOR_HD TissueAt operator()(std::uint32_t owner, Int3 voxel) const {
    const Int3 cell = v.node(owner / ResampleView::kClaims);
    if constexpr (kCells == Cells::kSpecial) return place_in_special(node_slot(v.lattice, cell), voxel);
    const int tet = int(owner % ResampleView::kClaims);
    return tet == 0   ? place<0>(cell, voxel)
           : tet == 1 ? place<1>(cell, voxel)
           : tet == 2 ? place<2>(cell, voxel)
           : tet == 3 ? place<3>(cell, voxel)
           : tet == 4 ? place<4>(cell, voxel)
                      : place<5>(cell, voxel);
  }
  /// By the first of its tetrahedra that has the voxel.
  TURGOR_HD TissueAt place_in_special(int slot, Int3 voxel) const {
    int low = 0, high = v.cuts.special_count - 1;
    while (low < high) {
      const int middle = (low + high) / 2;
      if (v.cuts.special[middle].slot < slot)
        low = middle + 1;
      else
        high = middle;
    }
    RasterWindow one = v.window;
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
  TURGOR_HD TissueAt place(Int3 cell, Int3 voxel) const {
    constexpr std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, kTet);
    bool solid = false;
    const DeformedTet tet = deform_tet<kTet>(v.corners(cell, nodes, solid), v.window.handed);
    return {PlaceOfVoxel(tet, v.window.bits, v.rest, cell)(voxel), float(tet.det * v.to_ratio)};
  }
};

/// Air, or what the CT has where the owner's tissue came from.
template <Cells kCells>
struct FillVoxel {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::uint32_t owner = v.owner[n];
    if (owner >= ResampleView::kBeside) {
      if (kCells == Cells::kWhole) v.out[n] = kAirHu;
    } else if (const FindTissue<kCells> find{v}; find.has(owner)) {
      v.out[n] = value(find(owner, v.voxel(n)));
    }
  }
  TURGOR_HD std::int16_t value(TissueAt tissue) const {
    float value = v.sample(tissue.place);
    if (v.conserve_mass) value = (value - kAirHu) / tissue.ratio + kAirHu;
    return to_hu(value);
  }
};

/// One of deformed_fields.hpp.
template <Cells kCells, class Of, class Sample>
struct FillField : Of {
  ResampleView v;
  Sample* field;  // by voxel

  TURGOR_HD void operator()(std::size_t n) const {
    const std::uint32_t owner = v.owner[n];
    if (owner >= ResampleView::kBeside) {
      if (kCells == Cells::kWhole) field[n] = Of::outside();
    } else if (const FindTissue<kCells> find{v}; find.has(owner)) {
      const Int3 voxel = v.voxel(n);
      const TissueAt tissue = find(owner, voxel);
      field[n] = Of::operator()(voxel, tissue.place, tissue.ratio);
    }
  }
};
template <class Run, class Of, class Sample>
void fill_field_with(const Run& run, const ResampleView& v, const Of& of, Sample* field) {
  run(v.voxel_count(), FillField<Cells::kWhole, Of, Sample>{of, v, field});
  if (v.is_cut()) run(v.voxel_count(), FillField<Cells::kSpecial, Of, Sample>{of, v, field});
}

/// One row of voxels.
struct CountTissue {
  ResampleView v;

  TURGOR_HD void operator()(std::size_t row) const {
    const auto begin = row * std::size_t(v.window.high.x), end = begin + std::size_t(v.window.high.x);
    std::uint32_t covered = 0;
    std::int64_t mass = 0;
    for (std::size_t n = begin; n < end; n++) {
      if (v.owner[n] >= ResampleView::kBeside) continue;
      covered++, mass += v.out[n] - kAirHu;
    }
    if (covered == 0) return;
    atomic_add(v.count(row).covered, covered), atomic_add(v.count(row).mass, std::uint64_t(mass));
  }
};

/// From nodes to the owners of voxels; FindMoved has gone before, and what it found has chosen the fixed
/// point.
template <class Run>
void claim_with(const Run& run, const ResampleView& v) {
  const auto nodes = std::size_t(node_count(v.lattice));
  run(nodes, PlaceNode{v});
  run(std::size_t(v.cuts.virtual_node_count), PlaceCopy{v});
  run(std::size_t(8 * v.cuts.ghost_count), PlaceGhostFragment{v});
  if (v.is_cut()) {
    run(std::size_t(slot_count(v.lattice)), ForgetSpecial{v});
    run(std::size_t(v.cuts.special_count), MarkSpecial{v});
  }
  run(v.voxel_count(), ForgetOwner{v});
  run(nodes, ClaimVoxels{v});
  run(std::size_t(v.cuts.special_count), ClaimSpecial{v});
}
/// And from there to HU.
template <class Run>
void resample_with(const Run& run, const ResampleView& v) {
  claim_with(run, v);
  run(v.voxel_count(), FillVoxel<Cells::kWhole>{v});
  if (v.is_cut()) run(v.voxel_count(), FillVoxel<Cells::kSpecial>{v});
  run(v.voxel_count() / std::size_t(v.window.high.x), CountTissue{v});
}

}  // namespace turgor::lattice

// What lies beside the body in its deformed CT, as loops over plain pointers after those of
// resample_kernels.hpp: the same numbers as fill_beside_body, in any order. Fringe grows from the skin by a
// voxel a pass; a voxel keeps the way back to the voxel of tissue that it goes with.
#pragma once

#include "turgor/models/lattice/resample/partial_volume_voxel.hpp"
#include "turgor/models/lattice/resample/resample_kernels.hpp"

namespace turgor::lattice {

/// A voxel of fringe in a word: the pass that it was reached in, and the way to its skin.
struct PartialVolumeSource {
  static constexpr int kBits = 6, kMiddle = 1 << (kBits - 1), kMask = (1 << kBits) - 1;
  static_assert(kMostReach + kBeyond < kMiddle);

  int pass = 0;
  Int3 way;

  TURGOR_HD std::uint32_t word() const {
    const Int3 w = way + Int3{kMiddle, kMiddle, kMiddle};
    return ResampleView::kBeside | std::uint32_t(pass << 3 * kBits | w.z << 2 * kBits | w.y << kBits | w.x);
  }
  static TURGOR_HD PartialVolumeSource of(std::uint32_t word) {
    const int w = int(word & ~ResampleView::kBeside);
    PartialVolumeSource found;
    found.pass = w >> 3 * kBits;
    found.way = Int3{w & kMask, w >> kBits & kMask, w >> 2 * kBits & kMask} - Int3{kMiddle, kMiddle, kMiddle};
    return found;
  }
};

struct PartialVolumeView {
  ResampleView v;
  VoxelBeside value;
  std::uint8_t* rest;  // by voxel: bit 0, its place showed body in the CT; bit 1, one within reach along x, y
  std::uint8_t* near_rest;  // by voxel: one within reach did; before that, one within reach along x
  int reach;                // of the fringe [voxels]
};

/// A voxel's own place in the CT: body?
struct MarkRest {
  PartialVolumeView f;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 p = f.v.voxel(n);
    f.rest[n] = f.value.rest.holds(f.value.place.in_row(f.value.place({0, p.y, p.z}), p.x));
  }
};
/// One axis of the box around it.
template <int kAxis>
struct SpreadRest {
  PartialVolumeView f;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 p = f.v.voxel(n), size = f.v.window.high;
    const std::uint8_t* from = kAxis == 1 ? f.near_rest : f.rest;
    const std::uint8_t bit = kAxis == 2 ? 2 : 1;
    const auto x = std::ptrdiff_t(size.x), step = kAxis == 0 ? 1 : kAxis == 1 ? x : x * size.y;
    const int last = size[kAxis] - 1 - p[kAxis];
    const int down = p[kAxis] < f.reach ? p[kAxis] : f.reach, up = last < f.reach ? last : f.reach;
    std::uint8_t any = 0;
    for (int d = -down; d <= up; d++) any |= from[std::ptrdiff_t(n) + d * step];
    any = (any & bit) != 0;
    if (kAxis == 1)
      f.rest[n] = std::uint8_t(f.rest[n] | any << 1);
    else
      f.near_rest[n] = any;
  }
};

/// The voxels that one pass reaches: each goes with its nearest neighbour, across faces first, then across
/// edges.
struct GrowPartialVolume {
  PartialVolumeView f;
  int pass;  // from 1 on

  TURGOR_HD void operator()(std::size_t n) const {
    if (shared_load(f.v.owner[n]) != ResampleView::kNobody) return;
    const Int3 p = f.v.voxel(n), last = f.v.window.high - Int3{1, 1, 1};
    for (int distance = 1; distance <= 3; distance++)
      for (int around = 0; around < 27; around++) {
        const Int3 way = way_around(around), other = p + way;
        if (dot(way, way) != distance || !(other == min(max(other, Int3{0, 0, 0}), last))) continue;
        PartialVolumeSource found;
        if (!is_source(shared_load(f.v.owner[f.v.voxel_index(other)]), found)) continue;
        found.pass = pass, found.way = way + found.way;
        shared_store(f.v.owner[n], found.word());
        return;
      }
  }
  /// Tissue near the CT's air, or what an earlier pass reached.
  TURGOR_HD bool is_source(std::uint32_t owner, PartialVolumeSource& found) const {
    if (owner == ResampleView::kNobody) return false;
    if (owner < ResampleView::kBeside)
      return f.value.rest.is_near_air(f.v.node(owner / ResampleView::kClaims));
    found = PartialVolumeSource::of(owner);
    return found.pass < pass;
  }
};

template <Cells kCells>
struct FillBeside {
  PartialVolumeView f;

  TURGOR_HD void operator()(std::size_t n) const {
    const std::uint32_t owner = f.v.owner[n];
    if (owner < ResampleView::kBeside) return;
    const Int3 p = f.v.voxel(n);
    NearSkin skin;
    if (owner != ResampleView::kNobody) {
      const PartialVolumeSource found = PartialVolumeSource::of(owner);
      const Int3 from = p + found.way;
      const FindTissue<kCells> find{f.v};
      const std::uint32_t owner_there = f.v.owner[f.v.voxel_index(from)];
      if (!find.has(owner_there)) return;
      const TissueAt tissue = find(owner_there, from);
      skin = {.is_allocated = true,
              .is_beyond = found.pass > f.reach,
              .shift = rim_shift(f.value.place, from, tissue.place)};
    } else if (kCells == Cells::kSpecial) {
      return;
    }
    f.v.out[n] = f.value(p, n, WasBody{(f.rest[n] & 1) != 0, f.near_rest[n] != 0}, skin);
  }
};

/// Where the CT showed body: it does not change while the body moves.
template <class Run>
void mark_rest_with(const Run& run, const PartialVolumeView& f) {
  run(f.v.voxel_count(), MarkRest{f});
  run(f.v.voxel_count(), SpreadRest<0>{f});
  run(f.v.voxel_count(), SpreadRest<1>{f});
  run(f.v.voxel_count(), SpreadRest<2>{f});
}
/// Fills what resample_with left.
template <class Run>
void fill_beside_with(const Run& run, const PartialVolumeView& f) {
  for (int pass = 1; pass <= f.reach + kBeyond; pass++) run(f.v.voxel_count(), GrowPartialVolume{f, pass});
  run(f.v.voxel_count(), FillBeside<Cells::kWhole>{f});
  if (f.v.is_cut()) run(f.v.voxel_count(), FillBeside<Cells::kSpecial>{f});
}

}  // namespace turgor::lattice

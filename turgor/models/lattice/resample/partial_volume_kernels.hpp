// Kernels for the voxels outside the deformed body. They run after those of resample_kernels.hpp and give the
// same numbers as fill_outside_body, in any order. Partial volume grows from the skin by one voxel per pass.
// Each voxel stores the offset to its source voxel of tissue.
#pragma once

#include "turgor/models/lattice/resample/partial_volume_voxel.hpp"
#include "turgor/models/lattice/resample/resample_kernels.hpp"

namespace turgor::lattice {

/// Voxel of partial volume packed into a word: pass in which it was reached, and offset to its source.
struct PartialVolumeSource {
  static constexpr int kBits = 6, kMiddle = 1 << (kBits - 1), kMask = (1 << kBits) - 1;
  static_assert(kMaxReach + kExtraRings < kMiddle);

  int pass = 0;
  Int3 offset;

  TURGOR_HD std::uint32_t word() const {
    const Int3 w = offset + Int3{kMiddle, kMiddle, kMiddle};
    return ResampleView::kPartialVolume |
           std::uint32_t(pass << 3 * kBits | w.z << 2 * kBits | w.y << kBits | w.x);
  }
  static TURGOR_HD PartialVolumeSource of(std::uint32_t word) {
    const int w = int(word & ~ResampleView::kPartialVolume);
    PartialVolumeSource found;
    found.pass = w >> 3 * kBits;
    found.offset =
        Int3{w & kMask, w >> kBits & kMask, w >> 2 * kBits & kMask} - Int3{kMiddle, kMiddle, kMiddle};
    return found;
  }
};

struct PartialVolumeView {
  ResampleView v;
  OutsideVoxel value;
  std::uint8_t*
      rest;  // by voxel: bit 0, it shows body at rest; bit 1, a voxel within reach along x and y does
  std::uint8_t* near_rest;  // by voxel: a voxel within reach does; before that, one within reach along x
  int reach;                // width of the partial volume [voxels]
};

/// Marks voxels that show body at rest.
struct MarkRest {
  PartialVolumeView f;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 p = f.v.voxel(n);
    f.rest[n] = f.value.rest.holds(f.value.to_ct.in_row(f.value.to_ct({0, p.y, p.z}), p.x));
  }
};
/// Dilates the marks along one axis.
template <int kAxis>
struct SpreadRest {
  PartialVolumeView f;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 p = f.v.voxel(n), size = f.v.window.high;
    // input of this axis
    const std::uint8_t* from = kAxis == 1 ? f.near_rest : f.rest;
    const std::uint8_t bit = kAxis == 2 ? 2 : 1;
    const auto x = std::ptrdiff_t(size.x), step = kAxis == 0 ? 1 : kAxis == 1 ? x : x * size.y;
    // voxels within reach along the axis
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

/// Grows the partial volume by one voxel. Each new voxel takes the source of its nearest neighbor: faces
/// first, then edges, then corners.
struct GrowPartialVolume {
  PartialVolumeView f;
  int pass;  // from 1

  TURGOR_HD void operator()(std::size_t n) const {
    if (shared_load(f.v.owner[n]) != ResampleView::kUnclaimed) return;
    const Int3 p = f.v.voxel(n), last = f.v.window.high - Int3{1, 1, 1};
    for (int distance = 1; distance <= 3; distance++)
      for (int around = 0; around < 27; around++) {
        const Int3 offset = box_offset(around), other = p + offset;
        if (dot(offset, offset) != distance || !(other == min(max(other, Int3{0, 0, 0}), last))) continue;
        PartialVolumeSource found;
        if (!is_source(shared_load(f.v.owner[f.v.voxel_index(other)]), found)) continue;
        found.pass = pass, found.offset = offset + found.offset;
        shared_store(f.v.owner[n], found.word());
        return;
      }
  }
  /// True for tissue near the CT's air, and for voxels that an earlier pass reached.
  TURGOR_HD bool is_source(std::uint32_t owner, PartialVolumeSource& found) const {
    if (owner == ResampleView::kUnclaimed) return false;
    if (owner < ResampleView::kPartialVolume)
      return f.value.rest.is_near_air(f.v.node(owner / ResampleView::kClaims));
    found = PartialVolumeSource::of(owner);
    return found.pass < pass;
  }
};

template <Cells kCells>
struct FillOutside {
  PartialVolumeView f;

  // displacement of the nearest skin
  TURGOR_HD void operator()(std::size_t n) const {
    const std::uint32_t owner = f.v.owner[n];
    if (owner < ResampleView::kPartialVolume) return;
    const Int3 p = f.v.voxel(n);
    NearSkin skin;
    if (owner != ResampleView::kUnclaimed) {
      const PartialVolumeSource found = PartialVolumeSource::of(owner);
      const Int3 from = p + found.offset;
      const FindTissue<kCells> find{f.v};
      const std::uint32_t source_owner = f.v.owner[f.v.voxel_index(from)];
      if (!find.has(source_owner)) return;
      const TissueAt tissue = find(source_owner, from);
      skin = {.is_found = true,
              .is_beyond = found.pass > f.reach,
              .shift = rim_shift(f.value.to_ct, from, tissue.rest)};
    } else if (kCells == Cells::kSpecial) {
      // value of the voxel
      return;
    }
    f.v.out[n] = f.value(p, n, RestCoverage{(f.rest[n] & 1) != 0, f.near_rest[n] != 0}, skin);
  }
};

/// Marks the rest body on the grid. It does not depend on the deformation.
template <class Run>
void mark_rest_with(const Run& run, const PartialVolumeView& f) {
  run(f.v.voxel_count(), MarkRest{f});
  run(f.v.voxel_count(), SpreadRest<0>{f});
  run(f.v.voxel_count(), SpreadRest<1>{f});
  run(f.v.voxel_count(), SpreadRest<2>{f});
}
/// Fills the voxels that resample_with left.
template <class Run>
void fill_outside_with(const Run& run, const PartialVolumeView& f) {
  for (int pass = 1; pass <= f.reach + kExtraRings; pass++)
    run(f.v.voxel_count(), GrowPartialVolume{f, pass});
  run(f.v.voxel_count(), FillOutside<Cells::kWhole>{f});
  if (f.v.is_cut()) run(f.v.voxel_count(), FillOutside<Cells::kSpecial>{f});
}

}  // namespace turgor::lattice

#include "turgor/models/lattice/resample/partial_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/dilate.hpp"
#include "turgor/models/lattice/resample/deformed_body.hpp"

namespace turgor::lattice {

namespace {

using Mask = std::vector<std::uint8_t>;

/// Tile of a slab with a margin for its partial volume.
struct Window {
  static constexpr int kTile = 32;  // voxels along x and y

  Int3 begin, end;  // tile
  Int3 low, size;   // tile with its margin

  Window(const Grid& out, Int3 tile, int reach)
      : begin(hadamard(tile, {kTile, kTile, kVoxelLayers})),
        end(min(begin + Int3{kTile, kTile, kVoxelLayers}, out.size)),
        low(max(begin - Int3{reach, reach, reach}, {0, 0, 0})),
        size(min(end + Int3{reach, reach, reach}, out.size) - low) {}
  std::size_t index(Int3 p) const {
    return (std::size_t(p.z - low.z) * std::size_t(size.y) + std::size_t(p.y - low.y)) * std::size_t(size.x) +
           std::size_t(p.x - low.x);
  }
  Int3 voxel(std::size_t index) const {
    const auto row = index / std::size_t(size.x);
    return low + Int3{int(index % std::size_t(size.x)), int(row % std::size_t(size.y)),
                      int(row / std::size_t(size.y))};
  }
  bool contains(Int3 p) const {
    const Int3 high = low + size;
    return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x < high.x && p.y < high.y && p.z < high.z;
  }
  std::size_t count() const { return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z); }
};

/// True if all voxels of a box have this mark.
bool is_all(std::span<const std::uint8_t> mask, const Grid& grid, Int3 begin, Int3 end, std::uint8_t mark) {
  for (int k = begin.z; k < end.z; k++)
    for (int j = begin.y; j < end.y; j++) {
      const auto row = mask.subspan(sample_index(grid, begin.x, j, k), std::size_t(end.x - begin.x));
      if (std::any_of(row.begin(), row.end(), [&](std::uint8_t m) { return m != mark; })) return false;
    }
  return true;
}

bool comes_before(const RimVoxel& a, const RimVoxel& b) {
  return std::tie(a.voxel.z, a.voxel.y, a.voxel.x) < std::tie(b.voxel.z, b.voxel.y, b.voxel.x);
}

/// Rim voxels of a row from `from` up to i = `end`.
std::span<const RimVoxel> rim_of_row(const PartialVolumeInputs& inputs, Int3 from, int end) {
  const std::vector<RimVoxel>& rim = inputs.rim[std::size_t(from.z / kVoxelLayers)];
  const auto first = std::lower_bound(rim.begin(), rim.end(), RimVoxel{from, {}}, comes_before);
  const auto last = std::lower_bound(first, rim.end(), RimVoxel{{end, from.y, from.z}, {}}, comes_before);
  return {first, last};
}

/// Source in the rim of each voxel of partial volume in a window; -1 = none.
struct PartialVolume {
  const Window& window;
  std::vector<Vec3> shifts;
  std::vector<int> source;
  Mask beyond;  // by voxel of the window: farther from the skin than the blur

  PartialVolume(const PartialVolumeInputs& inputs, const Grid& out, const Window& w, int reach)
      : window(w), source(w.count(), -1), beyond(w.count()) {
    // rim voxels of the window
    std::vector<std::size_t> ring;
    for (int k = w.low.z; k < w.low.z + w.size.z; k++)
      for (int j = w.low.y; j < w.low.y + w.size.y; j++)
        for (const RimVoxel& rim : rim_of_row(inputs, {w.low.x, j, k}, w.low.x + w.size.x)) {
          source[window.index(rim.voxel)] = int(shifts.size());
          shifts.push_back(rim.shift);
          ring.push_back(window.index(rim.voxel));
        }
    // rings of partial volume, then rings beyond the blur
    for (int n = 0; n < reach; n++) ring = grow(inputs, out, ring);
    for (int n = 0; n < kExtraRings; n++) {
      ring = grow(inputs, out, ring);
      for (const std::size_t at : ring) beyond[at] = 1;
    }
  }

  NearSkin near(std::size_t n) const {
    if (source[n] < 0) return {.is_beyond = beyond[n] != 0};
    return {.is_found = true, .is_beyond = beyond[n] != 0, .shift = shifts[std::size_t(source[n])]};
  }

  /// Grows a ring by one voxel into voxels that neither tissue nor an earlier ring covers. Each takes the
  /// source of its nearest neighbor.
  std::vector<std::size_t> grow(const PartialVolumeInputs& inputs, const Grid& out,
                                const std::vector<std::size_t>& ring) {
    static const std::array<Int3, 26> kOffsets = neighbors_by_distance();
    constexpr int kNext = -2;
    // voxels of the next ring
    std::vector<std::size_t> next;
    for (const std::size_t from : ring)
      for (const Int3 offset : kOffsets) {
        const Int3 p = window.voxel(from) + offset;
        if (!window.contains(p) || source[window.index(p)] != -1) continue;
        if (inputs.covered[sample_index(out, p.x, p.y, p.z)]) continue;
        source[window.index(p)] = kNext;
        next.push_back(window.index(p));
      }
    // sources, from the previous rings only
    std::vector<int> found;
    for (const std::size_t at : next)
      for (const Int3 offset : kOffsets) {
        const Int3 p = window.voxel(at) + offset;
        if (!window.contains(p) || source[window.index(p)] < 0) continue;
        found.push_back(source[window.index(p)]);
        break;
      }
    TURGOR_CHECK(found.size() == next.size(), "every new voxel has a neighbor with a source");
    for (std::size_t n = 0; n < next.size(); n++) source[next[n]] = found[n];
    return next;
  }
};

/// Mask of the voxels of a window that show body at rest.
Mask body_at_rest(const RestBody& body, const OutputToCt& to_ct, const Window& window) {
  Mask rest(window.count());
  std::size_t n = 0;
  const Int3 high = window.low + window.size;
  for (int k = window.low.z; k < high.z; k++)
    for (int j = window.low.y; j < high.y; j++) {
      const Vec3d first = to_ct({0, j, k});
      for (int i = window.low.x; i < high.x; i++) rest[n++] = body.holds(to_ct.in_row(first, i));
    }
  return rest;
}

/// True if a window shows no body, at rest and now.
bool is_untouched(const PartialVolumeInputs& inputs, const Grid& out, const OutputToCt& to_ct,
                  const Window& window) {
  const Int3 end = window.low + window.size, last = end - Int3{1, 1, 1};
  if (!is_all(inputs.covered, out, window.low, end, 0)) return false;
  // bounds of the window in the CT
  Vec3d low = to_ct(window.low), high = low;
  for (int corner = 1; corner < 8; corner++) {
    const Vec3d at = to_ct({corner & 1 ? last.x : window.low.x, corner & 2 ? last.y : window.low.y,
                            corner & 4 ? last.z : window.low.z});
    low = min(low, at), high = max(high, at);
  }
  return inputs.rest.is_air(low, high);
}

}  // namespace

std::array<Int3, 26> neighbors_by_distance() {
  std::array<Int3, 26> offsets;
  std::size_t count = 0;
  for (int distance = 1; distance <= 3; distance++)
    for (int n = 0; n < 27; n++) {
      const Int3 offset{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
      if (std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z) == distance) offsets[count++] = offset;
    }
  return offsets;
}

int blur_reach(const Grid& out, const Grid& ct) {
  double reach = 1;
  for (int axis = 0; axis < 3; axis++)
    reach = std::max(reach, std::ceil(kBlur * ct.spacing[axis] / out.spacing[axis] - 1e-6));
  return int(std::min(reach, double(kMaxReach)));
}

RestBody::RestBody(const Exec& exec, const Model& model, Vec3d first_node, Vec3d cell_size)
    : lattice_(model.anatomy.lattice),
      first_node_(first_node),
      per_cell_{1 / cell_size.x, 1 / cell_size.y, 1 / cell_size.z},
      marks_(model.anatomy.tissue.size()) {
  const Lattice& l = model.anatomy.lattice;
  const Int3 last = l.size - Int3{2, 2, 2};  // last cell
  // kinds of nodes and cells
  parallel_for(exec, std::size_t(l.size.z), [&](std::size_t k) {
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const auto slot = std::size_t(node_slot(l, i, j, int(k)));
        std::uint8_t mark = is_body(model.anatomy.tissue[slot]) ? kNodeIsBody : 0;
        if (i <= last.x && j <= last.y && int(k) <= last.z)
          for (int c = 0; c < 8; c++) {
            const int corner = int(slot) + slot_offset(l, cell_corner(c), i & 1);
            mark |= is_body(model.anatomy.tissue[std::size_t(corner)]) ? kCellHasBody : kCellHasAir;
          }
        marks_[slot] = mark;
      }
  });
  // cells next to rim cells
  for (int k = 0; k <= last.z; k++)
    for (int j = 0; j <= last.y; j++)
      for (int i = 0; i <= last.x; i++) {
        constexpr std::uint8_t kRim = kCellHasBody | kCellHasAir;
        if ((marks_[std::size_t(node_slot(l, i, j, k))] & kRim) != kRim) continue;
        for (int n = 0; n < 27; n++) {
          const Int3 other = Int3{i, j, k} + Int3{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
          marks_[std::size_t(node_slot(l, min(max(other, Int3{0, 0, 0}), last)))] |= kCellNearAir;
        }
      }
}

bool RestBody::is_air(Vec3d low, Vec3d high) const {
  const Lattice& l = lattice_;
  const auto cell_at = [&](Vec3d at, int more) {
    const Vec3d node = hadamard(at - first_node_, per_cell_);
    return Int3{int(std::floor(node.x)), int(std::floor(node.y)), int(std::floor(node.z))} +
           Int3{more, more, more};
  };
  const Int3 from = max(cell_at(low, -1), {0, 0, 0}), to = min(cell_at(high, 2), l.size - Int3{1, 1, 1});
  for (int k = from.z; k < to.z; k++)
    for (int j = from.y; j < to.y; j++)
      for (int i = from.x; i < to.x; i++)
        if (marks_[std::size_t(node_slot(l, i, j, k))] & kCellHasBody) return false;
  return true;
}

OutputToCt::OutputToCt(const Grid& out, const Grid& ct) {
  const auto at = [&](Int3 p) { return index_at(ct, point_at(out, Vec3d(p))); };
  first = at({0, 0, 0});
  step = {{at({1, 0, 0}) - first, at({0, 1, 0}) - first, at({0, 0, 1}) - first}};
}

OutsideVoxel outside_voxel(const CtVolume& ct, double air_max, const Grid& out, const RestBodyView& rest,
                           const SurroundingsView& surroundings) {
  return {.rest = rest,
          .surroundings = surroundings,
          .to_ct = OutputToCt(out, ct.grid),
          .sample = CtSampler(ct),
          .size = ct.grid.size,
          .same = same_grid(out, ct.grid),
          .dense = std::int16_t(std::ceil(air_max))};
}

void keep_rim(const Grid& out, std::span<const std::uint8_t> covered, std::vector<RimVoxel>& rim) {
  std::erase_if(rim, [&](const RimVoxel& r) {
    const Int3 low = max(r.voxel - Int3{1, 1, 1}, {0, 0, 0}), end = min(r.voxel + Int3{2, 2, 2}, out.size);
    return is_all(covered, out, low, end, 1);
  });
  std::sort(rim.begin(), rim.end(), comes_before);
}

namespace {

void fill_surroundings(const PartialVolumeInputs& inputs, const OutputToCt& to_ct, const Window& tile,
                       CtVolume& out) {
  const CtSampler sample(inputs.ct);
  const bool same = same_grid(out.grid, inputs.ct.grid);
  for (int k = tile.begin.z; k < tile.end.z; k++)
    for (int j = tile.begin.y; j < tile.end.y; j++) {
      const std::size_t row = sample_index(out.grid, 0, j, k);
      for (int i = tile.begin.x; i < tile.end.x; i++)
        out.samples[row + std::size_t(i)] = same ? inputs.ct.samples[row + std::size_t(i)]
                                                 : std::int16_t(std::lrint(sample(Vec3(to_ct({i, j, k})))));
    }
}

void fill_tile(const PartialVolumeInputs& inputs, const OutputToCt& to_ct, const Window& window, int reach,
               CtVolume& out) {
  const PartialVolume partial_volume(inputs, out.grid, window, reach);
  // voxels that show body at rest, and those near them
  const Mask rest = body_at_rest(inputs.rest, to_ct, window);
  Mask near_rest = rest;
  dilate(Exec(1), near_rest, window.size, reach);

  // values of the voxels without tissue
  const OutsideVoxel value_at = outside_voxel(inputs.ct, inputs.model.params.tissue.air_max, out.grid,
                                              inputs.rest.view(), view(inputs.surroundings));
  for (int k = window.begin.z; k < window.end.z; k++)
    for (int j = window.begin.y; j < window.end.y; j++)
      for (int i = window.begin.x; i < window.end.x; i++) {
        const std::size_t voxel = sample_index(out.grid, i, j, k);
        if (inputs.covered[voxel]) continue;
        const std::size_t n = window.index({i, j, k});
        const RestCoverage was{rest[n] != 0, near_rest[n] != 0};
        out.samples[voxel] = value_at({i, j, k}, voxel, was, partial_volume.near(n));
      }
}

}  // namespace

void fill_outside_body(const PartialVolumeInputs& inputs, int slab, CtVolume& out) {
  TURGOR_CHECK(inputs.covered.size() == out.samples.size(), "every voxel of the output has a mark");
  const int reach = blur_reach(out.grid, inputs.ct.grid);
  const OutputToCt to_ct(out.grid, inputs.ct.grid);
  for (int y = 0; y * Window::kTile < out.grid.size.y; y++)
    for (int x = 0; x * Window::kTile < out.grid.size.x; x++) {
      const Window tile(out.grid, {x, y, slab}, reach + kExtraRings);
      if (is_all(inputs.covered, out.grid, tile.begin, tile.end, 1)) continue;
      if (is_untouched(inputs, out.grid, to_ct, tile))
        fill_surroundings(inputs, to_ct, tile, out);
      else
        fill_tile(inputs, to_ct, tile, reach, out);
    }
}

}  // namespace turgor::lattice

#include "turgor/models/lattice/resample/partial_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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

/// Order of memory, as one number, for grids of up to 2²¹ samples along an axis.
std::int64_t memory_order(Int3 voxel) {
  return (std::int64_t(voxel.z) << 42) + (std::int64_t(voxel.y) << 21) + voxel.x;
}
bool comes_before(const RimVoxel& a, const RimVoxel& b) {
  return memory_order(a.voxel) < memory_order(b.voxel);
}

/// Rim voxels of a row from `from` up to i = `end`.
std::span<const RimVoxel> rim_of_row(const PartialVolumeInputs& inputs, Int3 from, int end) {
  const std::vector<RimVoxel>& rim = inputs.rim[std::size_t(from.z / kVoxelLayers)];
  const auto first = std::lower_bound(rim.begin(), rim.end(), RimVoxel{from, {}}, comes_before);
  const auto last = std::lower_bound(first, rim.end(), RimVoxel{{end, from.y, from.z}, {}}, comes_before);
  return {first, last};
}

/// Source in the rim of each voxel of partial volume in a window. The window has a border of blocked voxels,
/// so that every voxel has its 26 neighbors.
class PartialVolume {
 public:
  PartialVolume(const PartialVolumeInputs& inputs, const Grid& out, const Window& window, int reach)
      : low_(window.low - Int3{1, 1, 1}), size_(window.size + Int3{2, 2, 2}) {
    const std::array<Int3, 26> offsets = neighbors_by_distance();
    for (std::size_t n = 0; n < offsets.size(); n++) neighbors_[n] = index(low_ + offsets[n]);
    // voxels without tissue are free, except the border
    const std::ptrdiff_t count = std::ptrdiff_t(size_.x) * size_.y * size_.z;
    source_.assign(std::size_t(count), kBlocked), is_beyond_.resize(std::size_t(count));
    const Int3 end = window.low + window.size;
    for (int k = window.low.z; k < end.z; k++)
      for (int j = window.low.y; j < end.y; j++) {
        const std::uint8_t* covered = inputs.covered.data() + sample_index(out, window.low.x, j, k);
        int* source = source_.data() + index({window.low.x, j, k});
        for (int i = 0; i < window.size.x; i++) source[i] = covered[i] ? kBlocked : kFree;
      }
    // rim voxels
    for (int k = window.low.z; k < end.z; k++)
      for (int j = window.low.y; j < end.y; j++)
        for (const RimVoxel& rim : rim_of_row(inputs, {window.low.x, j, k}, end.x)) {
          at(rim.voxel) = int(shifts_.size());
          shifts_.push_back(rim.shift);
          ring_.push_back(index(rim.voxel));
        }
    // rings of partial volume, then rings beyond the blur
    for (int n = 0; n < reach; n++) grow();
    for (int n = 0; n < kExtraRings; n++) {
      grow();
      for (const std::ptrdiff_t voxel : ring_) is_beyond_[std::size_t(voxel)] = 1;
    }
  }

  NearSkin near(Int3 p) const {
    const auto n = std::size_t(index(p));
    if (source_[n] < 0) return {};
    return {.is_found = true, .is_beyond = is_beyond_[n] != 0, .shift = shifts_[std::size_t(source_[n])]};
  }

 private:
  // sources besides the indices of shifts_
  static constexpr int kFree = -1, kNext = -2, kBlocked = -3;

  std::ptrdiff_t index(Int3 p) const {
    return (std::ptrdiff_t(p.z - low_.z) * size_.y + (p.y - low_.y)) * size_.x + (p.x - low_.x);
  }
  int& at(Int3 p) { return source_[std::size_t(index(p))]; }

  /// Grows the ring by one voxel into free voxels. Each takes the source of its nearest neighbor.
  void grow() {
    // voxels of the next ring
    next_.clear();
    for (const std::ptrdiff_t from : ring_)
      for (const std::ptrdiff_t offset : neighbors_) {
        int& source = source_[std::size_t(from + offset)];
        if (source != kFree) continue;
        source = kNext;
        next_.push_back(from + offset);
      }
    // sources, from the previous rings only
    found_.clear();
    for (const std::ptrdiff_t voxel : next_) {
      const auto nearest = std::find_if(neighbors_.begin(), neighbors_.end(), [&](std::ptrdiff_t offset) {
        return source_[std::size_t(voxel + offset)] >= 0;
      });
      TURGOR_CHECK(nearest != neighbors_.end(), "every new voxel has a neighbor with a source");
      found_.push_back(source_[std::size_t(voxel + *nearest)]);
    }
    for (std::size_t n = 0; n < next_.size(); n++) source_[std::size_t(next_[n])] = found_[n];
    std::swap(ring_, next_);
  }

  Int3 low_, size_;                           // window with its border
  std::array<std::ptrdiff_t, 26> neighbors_;  // offsets of indices, nearest first
  std::vector<int> source_;                   // by voxel of the window with its border
  Mask is_beyond_;                            // by voxel: farther from the skin than the blur
  std::vector<Vec3> shifts_;                  // of the rim
  std::vector<std::ptrdiff_t> ring_, next_;   // voxels of the outermost ring, of the next
  std::vector<int> found_;                    // sources of the next ring
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

void fill_tile(const PartialVolumeInputs& inputs, const OutputToCt& to_ct, Int3 tile, int reach,
               CtVolume& out) {
  const PartialVolume partial_volume(inputs, out.grid, Window(out.grid, tile, reach + kExtraRings), reach);
  // voxels that show body at rest, and those near them
  const Window window(out.grid, tile, reach);
  const Mask rest = body_at_rest(inputs.rest, to_ct, window);
  Mask near_rest = rest;
  dilate(Exec(1), near_rest, window.size, reach);

  // values of the voxels without tissue
  const OutsideVoxel value_at = outside_voxel(inputs.ct, inputs.model.params.tissue.air_max, out.grid,
                                              inputs.rest.view(), view(inputs.model.anatomy.surroundings));
  for (int k = window.begin.z; k < window.end.z; k++)
    for (int j = window.begin.y; j < window.end.y; j++)
      for (int i = window.begin.x; i < window.end.x; i++) {
        const std::size_t voxel = sample_index(out.grid, i, j, k);
        if (inputs.covered[voxel]) continue;
        const std::size_t n = window.index({i, j, k});
        const RestCoverage was{rest[n] != 0, near_rest[n] != 0};
        out.samples[voxel] = value_at({i, j, k}, voxel, was, partial_volume.near({i, j, k}));
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
        fill_tile(inputs, to_ct, {x, y, slab}, reach, out);
    }
}

}  // namespace turgor::lattice

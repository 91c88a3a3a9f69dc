#include "turgor/models/lattice/fringe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "turgor/geometry/dilate.hpp"
#include "turgor/models/lattice/ct_sampler.hpp"
#include "turgor/models/lattice/placed_body.hpp"

namespace turgor::lattice {

namespace {

/// A scanner blurs an edge by hardly more than this [voxels of the CT].
constexpr double kBlur = 3;
/// So much further from the skin it is still told whether that has hardly moved, by less than a voxel of the
/// CT: then it has not left [voxels of the output].
constexpr int kBeyond = 2;

using Mask = std::vector<std::uint8_t>;

/// How many voxels of the output that is.
int reach_in(const Grid& out, const Grid& ct) {
  double reach = 1;
  for (int axis = 0; axis < 3; axis++)
    reach = std::max(reach, std::ceil(kBlur * ct.spacing[axis] / out.spacing[axis] - 1e-6));
  return int(std::min(reach, double(kVoxelLayers)));
}

/// The 26 neighbours of a voxel, those across faces first, then across edges.
std::array<Int3, 26> neighbours_by_distance() {
  std::array<Int3, 26> ways;
  std::size_t count = 0;
  for (int distance = 1; distance <= 3; distance++)
    for (int n = 0; n < 27; n++) {
      const Int3 way{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
      if (std::abs(way.x) + std::abs(way.y) + std::abs(way.z) == distance) ways[count++] = way;
    }
  return ways;
}

/// A tile of a slab, and the voxels around it that its fringe may come from.
struct Window {
  static constexpr int kTile = 32;  // along x and y

  Int3 begin, end;  // the tile
  Int3 low, size;   // with what is around it

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

/// Have all rows of a box this mark?
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

/// Those of a row from a voxel on, before `end`.
std::span<const RimVoxel> rim_of_row(const FringeInputs& inputs, Int3 from, int end) {
  const std::vector<RimVoxel>& rim = inputs.rim[std::size_t(from.z / kVoxelLayers)];
  const auto first = std::lower_bound(rim.begin(), rim.end(), RimVoxel{from, {}}, comes_before);
  const auto last = std::lower_bound(first, rim.end(), RimVoxel{{end, from.y, from.z}, {}}, comes_before);
  return {first, last};
}

/// Which voxel of the rim the air near it goes with: by voxel of the window, −1 = none.
struct Fringe {
  const Window& window;
  std::vector<Vec3> shifts;
  std::vector<int> source;
  Mask beyond;  // by voxel of the window: farther than the fringe is wide

  Fringe(const FringeInputs& inputs, const Grid& out, const Window& w, int reach)
      : window(w), source(w.count(), -1), beyond(w.count()) {
    std::vector<std::size_t> ring;
    for (int k = w.low.z; k < w.low.z + w.size.z; k++)
      for (int j = w.low.y; j < w.low.y + w.size.y; j++)
        for (const RimVoxel& rim : rim_of_row(inputs, {w.low.x, j, k}, w.low.x + w.size.x)) {
          source[window.index(rim.voxel)] = int(shifts.size());
          shifts.push_back(rim.shift);
          ring.push_back(window.index(rim.voxel));
        }
    for (int n = 0; n < reach; n++) ring = grow(inputs, out, ring);
    for (int n = 0; n < kBeyond; n++) {
      ring = grow(inputs, out, ring);
      for (const std::size_t at : ring) beyond[at] = 1;
    }
  }

  bool has_hardly_moved(std::size_t n) const {
    if (source[n] < 0) return false;
    const Vec3 shift = shifts[std::size_t(source[n])];
    return dot(shift, shift) < 1;
  }

  /// The voxels beside a ring that neither tissue nor an earlier ring has. Each goes with its nearest
  /// neighbour.
  std::vector<std::size_t> grow(const FringeInputs& inputs, const Grid& out,
                                const std::vector<std::size_t>& ring) {
    static const std::array<Int3, 26> kWays = neighbours_by_distance();
    constexpr int kNext = -2;
    std::vector<std::size_t> next;
    for (const std::size_t from : ring)
      for (const Int3 way : kWays) {
        const Int3 p = window.voxel(from) + way;
        if (!window.contains(p) || source[window.index(p)] != -1) continue;
        if (inputs.covered[sample_index(out, p.x, p.y, p.z)]) continue;
        source[window.index(p)] = kNext;
        next.push_back(window.index(p));
      }
    std::vector<int> found;
    for (const std::size_t at : next)
      for (const Int3 way : kWays) {
        const Int3 p = window.voxel(at) + way;
        if (!window.contains(p) || source[window.index(p)] < 0) continue;
        found.push_back(source[window.index(p)]);
        break;
      }
    for (std::size_t n = 0; n < next.size(); n++) source[next[n]] = found[n];
    return next;
  }
};

/// Which voxels of a window showed body in the CT.
Mask body_at_rest(const RestBody& body, const PlaceInCt& place, const Window& window) {
  Mask rest(window.count());
  std::size_t n = 0;
  const Int3 high = window.low + window.size;
  for (int k = window.low.z; k < high.z; k++)
    for (int j = window.low.y; j < high.y; j++) {
      const Vec3d first = place({0, j, k});
      for (int i = window.low.x; i < high.x; i++)
        rest[n++] = body.holds(first + place.step.column[0] * double(i));
    }
  return rest;
}

/// Neither was there body in the CT nor is there any now.
bool is_untouched(const FringeInputs& inputs, const Grid& out, const PlaceInCt& place, const Window& window) {
  const Int3 end = window.low + window.size, last = end - Int3{1, 1, 1};
  if (!is_all(inputs.covered, out, window.low, end, 0)) return false;
  Vec3d low = place(window.low), high = low;
  for (int corner = 1; corner < 8; corner++) {
    const Vec3d at = place({corner & 1 ? last.x : window.low.x, corner & 2 ? last.y : window.low.y,
                            corner & 4 ? last.z : window.low.z});
    low = min(low, at), high = max(high, at);
  }
  return inputs.rest.is_air(low, high);
}

/// Tells the body's fringe from what lies beside the body.
struct FringeOfBody {
  const FringeInputs& inputs;
  std::int16_t dense;  // from here on it is no air [HU]

  /// Of a place that is no body: does it go with the skin? Air does, and a crumb of skin that is less than
  /// half of a block; the table does not.
  bool operator()(Vec3d at, float value) const { return value < float(dense) || is_crumb(at); }

  /// Tissue is where its cells are, and nowhere else; its blur may begin within them, by a voxel.
  bool is_tissue(Vec3d at, float value) const {
    if (!inputs.rest.holds(at)) return false;
    if (value >= float(dense)) return true;
    for (const Vec3d way : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
      if (!inputs.rest.holds(at + way) || !inputs.rest.holds(at - way)) return false;
    return true;
  }

 private:
  bool is_crumb(Vec3d at) const {
    constexpr int kReach = 2;
    const CtVolume& ct = inputs.ct;
    const Int3 p{int(std::lrint(at.x)), int(std::lrint(at.y)), int(std::lrint(at.z))};
    if (!contains(ct.grid, p)) return false;
    if (inputs.beside.has_row(p.y, p.z) && inputs.beside.row(p.y, p.z)[p.x / inputs.beside.cell.x])
      return false;
    const Int3 low = max(p - Int3{kReach, kReach, kReach}, Int3{0, 0, 0}),
               high = min(p + Int3{kReach, kReach, kReach}, ct.grid.size - Int3{1, 1, 1});
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (ct.at(i, j, k) >= dense && inputs.rest.holds(Vec3d(Int3{i, j, k}))) return true;
    return false;
  }
};

}  // namespace

RestBody::RestBody(const Exec& exec, const Model& model, Vec3d first_node, Vec3d cell_size)
    : model_(model),
      first_node_(first_node),
      per_cell_{1 / cell_size.x, 1 / cell_size.y, 1 / cell_size.z},
      cells_(model.tissue.size(), Cell::kAir),
      near_air_(model.tissue.size()) {
  const Lattice& l = model.lattice;
  const Int3 last = l.size - Int3{2, 2, 2};  // cell
  parallel_for(exec, std::size_t(std::max(0, last.z + 1)), [&](std::size_t k) {
    for (int j = 0; j <= last.y; j++)
      for (int i = 0; i <= last.x; i++) {
        const auto slot = std::size_t(node_slot(l, i, j, int(k)));
        int count = 0;
        for (int c = 0; c < 8; c++)
          count +=
              is_body(model.tissue[slot + std::size_t(slot_offset(l, {c & 1, c >> 1 & 1, c >> 2}, i & 1))]);
        cells_[slot] = count == 0 ? Cell::kAir : count == 8 ? Cell::kBody : Cell::kRim;
      }
  });
  for (int k = 0; k <= last.z; k++)
    for (int j = 0; j <= last.y; j++)
      for (int i = 0; i <= last.x; i++) {
        if (cells_[std::size_t(node_slot(l, i, j, k))] != Cell::kRim) continue;
        for (int n = 0; n < 27; n++) {
          const Int3 other = Int3{i, j, k} + Int3{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
          near_air_[std::size_t(node_slot(l, min(max(other, Int3{0, 0, 0}), last)))] = 1;
        }
      }
}

bool RestBody::holds(Vec3d at) const {
  constexpr int kBits = 16;  // snapped, so that rounding does not decide ties
  const Vec3d node = hadamard(at - first_node_, per_cell_) * double(1 << kBits);
  const Int3 snapped{int(std::lrint(node.x)), int(std::lrint(node.y)), int(std::lrint(node.z))};
  const Int3 cell{snapped.x >> kBits, snapped.y >> kBits, snapped.z >> kBits};
  const Lattice& l = model_.lattice;
  if (!contains(l, cell)) return false;
  const Cell kind = cells_[std::size_t(node_slot(l, cell))];
  if (kind != Cell::kRim) return kind == Cell::kBody;
  const auto corners =
      kuhn_corners(cell, kuhn_tet_at(snapped - Int3{cell.x << kBits, cell.y << kBits, cell.z << kBits}));
  return std::any_of(corners.begin(), corners.end(), [&](Int3 node_at) {
    return is_body(model_.tissue[std::size_t(node_slot(l, node_at))]);
  });
}

bool RestBody::is_air(Vec3d low, Vec3d high) const {
  const Lattice& l = model_.lattice;
  const auto cell_at = [&](Vec3d at, int more) {
    const Vec3d node = hadamard(at - first_node_, per_cell_);
    return Int3{int(std::floor(node.x)), int(std::floor(node.y)), int(std::floor(node.z))} +
           Int3{more, more, more};
  };
  const Int3 from = max(cell_at(low, -1), {0, 0, 0}), to = min(cell_at(high, 2), l.size - Int3{1, 1, 1});
  for (int k = from.z; k < to.z; k++)
    for (int j = from.y; j < to.y; j++)
      for (int i = from.x; i < to.x; i++)
        if (cells_[std::size_t(node_slot(l, i, j, k))] != Cell::kAir) return false;
  return true;
}

PlaceInCt::PlaceInCt(const Grid& out, const Grid& ct) {
  const auto at = [&](Int3 p) { return index_at(ct, point_at(out, Vec3d(p))); };
  first = at({0, 0, 0});
  step = {{at({1, 0, 0}) - first, at({0, 1, 0}) - first, at({0, 0, 1}) - first}};
}

RimVoxel rim_voxel(const PlaceInCt& place, Int3 voxel, Vec3 at) {
  const Vec3d shift = (Vec3d(at) - place(voxel)) * 1024.0;
  return {voxel, Vec3(Vec3d{std::rint(shift.x), std::rint(shift.y), std::rint(shift.z)} * (1 / 1024.0))};
}

void keep_rim(const Grid& out, std::span<const std::uint8_t> covered, std::vector<RimVoxel>& rim) {
  std::erase_if(rim, [&](const RimVoxel& r) {
    const Int3 low = max(r.voxel - Int3{1, 1, 1}, {0, 0, 0}), end = min(r.voxel + Int3{2, 2, 2}, out.size);
    return is_all(covered, out, low, end, 1);
  });
  std::sort(rim.begin(), rim.end(), comes_before);
}

namespace {

void fill_surroundings(const FringeInputs& inputs, const PlaceInCt& place, const Window& tile,
                       CtVolume& out) {
  const Sampler sample(inputs.ct);
  const bool same = same_grid(out.grid, inputs.ct.grid);
  for (int k = tile.begin.z; k < tile.end.z; k++)
    for (int j = tile.begin.y; j < tile.end.y; j++) {
      const std::size_t row = sample_index(out.grid, 0, j, k);
      for (int i = tile.begin.x; i < tile.end.x; i++)
        out.samples[row + std::size_t(i)] = same ? inputs.ct.samples[row + std::size_t(i)]
                                                 : std::int16_t(std::lrint(sample(Vec3(place({i, j, k})))));
    }
}

void fill_tile(const FringeInputs& inputs, const PlaceInCt& place, const Window& window, int reach,
               CtVolume& out) {
  const Fringe fringe(inputs, out.grid, window, reach);
  const Mask rest = body_at_rest(inputs.rest, place, window);
  Mask near_rest = rest;
  dilate(Exec(1), near_rest, window.size, reach);

  const Sampler sample(inputs.ct);
  const FringeOfBody is_fringe{inputs, std::int16_t(std::ceil(inputs.model.params.tissue.air_max))};
  const bool same = same_grid(out.grid, inputs.ct.grid);
  const auto value_at = [&](Int3 p, std::size_t voxel) {
    const std::size_t n = window.index(p);
    const int source =
        fringe.beyond[n] && !(near_rest[n] && fringe.has_hardly_moved(n)) ? -1 : fringe.source[n];
    if (same && !near_rest[n] && source < 0) return inputs.ct.samples[voxel];
    const Vec3d at = place(p);
    const float here = sample(Vec3(at));
    if (!(near_rest[n] || source >= 0) || !(rest[n] || is_fringe(at, here)))
      return std::int16_t(std::lrint(here));
    const Vec3d before = at + (source < 0 ? Vec3d{} : Vec3d(fringe.shifts[std::size_t(source)]));
    const float moved = sample(Vec3(before));
    const bool from_fringe = is_fringe(before, moved);
    float value = near_rest[n] ? kAirHu : here;
    if (source >= 0 && from_fringe && !is_fringe.is_tissue(before, moved)) value = moved;
    if (!from_fringe && !rest[n] && fringe.has_hardly_moved(n)) value = here;  // a cover of the table
    return std::int16_t(std::lrint(value));
  };
  for (int k = window.begin.z; k < window.end.z; k++)
    for (int j = window.begin.y; j < window.end.y; j++)
      for (int i = window.begin.x; i < window.end.x; i++) {
        const std::size_t voxel = sample_index(out.grid, i, j, k);
        if (!inputs.covered[voxel]) out.samples[voxel] = value_at({i, j, k}, voxel);
      }
}

}  // namespace

void fill_beside_body(const FringeInputs& inputs, int slab, CtVolume& out) {
  const int reach = reach_in(out.grid, inputs.ct.grid);
  const PlaceInCt place(out.grid, inputs.ct.grid);
  for (int y = 0; y * Window::kTile < out.grid.size.y; y++)
    for (int x = 0; x * Window::kTile < out.grid.size.x; x++) {
      const Window tile(out.grid, {x, y, slab}, reach + kBeyond);
      if (is_all(inputs.covered, out.grid, tile.begin, tile.end, 1)) continue;
      if (is_untouched(inputs, out.grid, place, tile))
        fill_surroundings(inputs, place, tile, out);
      else
        fill_tile(inputs, place, tile, reach, out);
    }
}

}  // namespace turgor::lattice

// What a voxel beside the deformed body shows: where the CT shows body, which air goes with the skin, and
// what stays. Over plain pointers, for the CPU (partial_volume.cpp) and for threads of a GPU
// (partial_volume_kernels.hpp). Places are indices of the CT's voxels.
#pragma once

#include "turgor/models/lattice/build/surroundings.hpp"
#include "turgor/models/lattice/resample/ct_sampler.hpp"
#include "turgor/models/lattice/resample/raster.hpp"

namespace turgor::lattice {

/// Bits by slot: is the node body; of the cell above it, has it nodes of body, has it others, and is it such
/// a rim cell or beside one?
enum RestMark : std::uint8_t { kNodeIsBody = 1, kCellHasBody = 2, kCellHasAir = 4, kCellNearAir = 8 };

/// Where the CT shows body: the tetrahedra with a node of body.
struct RestBodyView {
  Lattice lattice;
  Vec3d first_node, per_cell;
  const std::uint8_t* marks;  // RestMark by slot

  TURGOR_HD bool holds(Vec3d at) const {
    constexpr int kBits = 16;  // snapped, so that rounding does not decide ties
    const Vec3d node = hadamard(at - first_node, per_cell) * double(1 << kBits);
    const Int3 snapped{int(lrint(node.x)), int(lrint(node.y)), int(lrint(node.z))};
    const Int3 cell{snapped.x >> kBits, snapped.y >> kBits, snapped.z >> kBits};
    if (!contains(lattice, cell)) return false;
    const std::uint8_t kind = marks[node_slot(lattice, cell)] & (kCellHasBody | kCellHasAir);
    if (kind != (kCellHasBody | kCellHasAir)) return kind == kCellHasBody;
    const int tet = kuhn_tet_at(snapped - Int3{cell.x << kBits, cell.y << kBits, cell.z << kBits});
    const std::array<Int3, 4> corners = kuhn_corners(cell, tet);
    bool any = false;
    for (std::size_t n = 0; n < 4; n++) any |= (marks[node_slot(lattice, corners[n])] & kNodeIsBody) != 0;
    return any;
  }
  /// A cell with a node that is no body and one that is, or one beside such a cell?
  TURGOR_HD bool is_near_air(Int3 cell) const {
    return (marks[node_slot(lattice, cell)] & kCellNearAir) != 0;
  }
};

/// The way from voxels of an output to those of the CT, where nothing has moved.
struct PlaceInCt {
  Vec3d first;
  Mat3d step;

  PlaceInCt(const Grid& out, const Grid& ct);
  TURGOR_HD Vec3d operator()(Int3 voxel) const { return first + step * Vec3d(voxel); }
  /// A voxel of a row, from the place of the row's first.
  TURGOR_HD Vec3d in_row(Vec3d row, int i) const { return row + step.column[0] * double(i); }
};

/// How far tissue lay in the CT, at `at`, from where it is now [voxels of the CT]. In parts of 1/1024, so
/// that what has not moved has no shift.
TURGOR_HD inline Vec3 rim_shift(const PlaceInCt& place, Int3 voxel, Vec3 at) {
  const Vec3d shift = (Vec3d(at) - place(voxel)) * 1024.0;
  return Vec3(Vec3d{rint(shift.x), rint(shift.y), rint(shift.z)} * (1 / 1024.0));
}

/// BesideBody on either side of a bus.
struct BesideView {
  Int3 cell{1, 1, 1}, size;
  const std::uint8_t *mask = nullptr, *row_mask = nullptr;

  TURGOR_HD bool holds(Int3 voxel) const {
    const int row = voxel.z / cell.z * size.y + voxel.y / cell.y;
    return row_mask[row] != 0 && mask[std::size_t(row) * std::size_t(size.x) + std::size_t(voxel.x / cell.x)];
  }
};

inline BesideView view(const Surroundings& beside) {
  return {beside.cell, beside.size, beside.mask.data(), beside.row_mask.data()};
}

/// The nearest skin of a voxel: how far it has moved, and whether it is farther away than the fringe is wide.
struct NearSkin {
  bool is_allocated = false, is_beyond = false;
  Vec3 shift;  // [voxels of the CT]

  TURGOR_HD bool has_hardly_moved() const { return is_allocated && dot(shift, shift) < 1; }
};

/// Where in the CT a voxel's own place showed body, and whether that was near.
struct WasBody {
  bool here = false, near = false;
};

/// Tells the body's fringe from what lies beside the body, and says what voxels without tissue show.
struct VoxelBeside {
  RestBodyView rest;
  BesideView beside;
  PlaceInCt place;
  Sampler sample;      // of the CT
  Int3 size;           // of the CT
  bool same;           // is the output's grid the CT's?
  std::int16_t dense;  // from here on it is no air [HU]

  /// Air within reach of the skin goes with the nearest skin; what that air and the body have left is air;
  /// all else is as it was.
  TURGOR_HD std::int16_t operator()(Int3 p, std::size_t voxel, WasBody was, NearSkin skin) const {
    const bool has_hardly_moved = skin.has_hardly_moved();
    if (skin.is_beyond && !(was.near && has_hardly_moved)) skin.is_allocated = false;
    if (same && !was.near && !skin.is_allocated) return sample.samples[voxel];
    const Vec3d at = place(p);
    const float here = sample(Vec3(at));
    if (!(was.near || skin.is_allocated) || !(was.here || is_fringe(at, here)))
      return std::int16_t(lrintf(here));
    const Vec3d before = at + (skin.is_allocated ? Vec3d(skin.shift) : Vec3d{});
    const float moved = sample(Vec3(before));
    const bool from_fringe = is_fringe(before, moved);
    float value = was.near ? float(kAirHu) : here;
    if (skin.is_allocated && from_fringe && !is_tissue(before, moved)) value = moved;
    if (!from_fringe && !was.here && has_hardly_moved) value = here;  // a cover of the table
    return std::int16_t(lrintf(value));
  }

 private:
  TURGOR_HD int at_ct(Int3 p) const {
    return sample.samples[std::size_t(p.z) * sample.layer + std::size_t(p.y) * sample.row + std::size_t(p.x)];
  }
  /// Of a place that is no body: does it go with the skin? Air does, and a crumb of skin that is less than
  /// half of a block; the table does not.
  TURGOR_HD bool is_fringe(Vec3d at, float value) const {
    return value < float(dense) || is_small_component(at);
  }

  /// Tissue is where its cells are, and nowhere else; its blur may begin within them, by a voxel.
  TURGOR_HD bool is_tissue(Vec3d at, float value) const {
    if (!rest.holds(at)) return false;
    if (value >= float(dense)) return true;
    for (int axis = 0; axis < 3; axis++) {
      const Vec3d way{double(axis == 0), double(axis == 1), double(axis == 2)};
      if (!rest.holds(at + way) || !rest.holds(at - way)) return false;
    }
    return true;
  }
  TURGOR_HD bool is_small_component(Vec3d at) const {
    constexpr int kReach = 2;
    const Int3 p{int(lrint(at.x)), int(lrint(at.y)), int(lrint(at.z))}, last = size - Int3{1, 1, 1};
    if (!(p == min(max(p, Int3{0, 0, 0}), last)) || beside.holds(p)) return false;
    const Int3 low = max(p - Int3{kReach, kReach, kReach}, Int3{0, 0, 0}),
               high = min(p + Int3{kReach, kReach, kReach}, last);
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (at_ct({i, j, k}) >= dense && rest.holds(Vec3d(Int3{i, j, k}))) return true;
    return false;
  }
};

VoxelBeside voxel_beside(const CtVolume& ct, double air_max, const Grid& out, const RestBodyView& rest,
                         const BesideView& beside);

/// A scanner blurs an edge by hardly more than this [voxels of the CT].
constexpr double kBlur = 3;
/// So much further from the skin it is still told whether that has hardly moved, by less than a voxel of the
/// CT: then it has not left [voxels of the output].
constexpr int kBeyond = 2;
/// Farther than this the fringe does not reach [voxels of the output].
constexpr int kMostReach = 16;
/// How many voxels of the output the blur is.
int reach_in(const Grid& out, const Grid& ct);

}  // namespace turgor::lattice

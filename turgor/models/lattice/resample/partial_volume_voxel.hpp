// Value of a voxel outside the deformed body: rest body, partial volume that moves with the skin, or
// surroundings that do not move. Plain pointers, for host (partial_volume.cpp) and device
// (partial_volume_kernels.hpp). Positions are voxel indices of the CT.
#pragma once

#include "turgor/geometry/ct_sampler.hpp"
#include "turgor/geometry/kuhn_raster.hpp"
#include "turgor/models/lattice/model/surroundings.hpp"

namespace turgor::lattice {

/// Bits by slot: the node is body; the cell above it has body nodes, has air nodes, is such a rim cell or
/// next to one.
enum RestMark : std::uint8_t { kNodeIsBody = 1, kCellHasBody = 2, kCellHasAir = 4, kCellNearAir = 8 };

/// Body in the CT at rest: the tetrahedra with a body node.
struct RestBodyView {
  Lattice lattice;
  Vec3d first_node, per_cell;
  const std::uint8_t* marks;  // RestMark by slot

  TURGOR_HD bool holds(Vec3d at) const {
    constexpr int kBits = 16;  // fixed point, so that ties do not depend on rounding
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
  /// True for a rim cell, with body and air nodes, and for a cell next to one.
  TURGOR_HD bool is_near_air(Int3 cell) const {
    return (marks[node_slot(lattice, cell)] & kCellNearAir) != 0;
  }
};

/// Affine map from voxels of the output to voxels of the CT.
struct OutputToCt {
  Vec3d first;
  Mat3d step;

  OutputToCt(const Grid& out, const Grid& ct);
  TURGOR_HD Vec3d operator()(Int3 voxel) const { return first + step * Vec3d(voxel); }
  /// Position of voxel i of a row, from that of the row's first voxel.
  TURGOR_HD Vec3d in_row(Vec3d row, int i) const { return row + step.column[0] * double(i); }
};

/// Displacement of tissue from its current voxel to its rest position `at` [voxels of the CT]. Rounded to
/// 1/1024, so that tissue at rest has zero displacement.
TURGOR_HD inline Vec3 rim_shift(const OutputToCt& to_ct, Int3 voxel, Vec3 at) {
  const Vec3d shift = (Vec3d(at) - to_ct(voxel)) * 1024.0;
  return Vec3(Vec3d{rint(shift.x), rint(shift.y), rint(shift.z)} * (1 / 1024.0));
}

/// Surroundings in host or device memory. Without cells, there are none.
struct SurroundingsView {
  Int3 cell{1, 1, 1}, size;
  const std::uint8_t *mask = nullptr, *row_mask = nullptr;

  TURGOR_HD bool holds(Int3 voxel) const {
    if (size.x == 0) return false;
    const int row = voxel.z / cell.z * size.y + voxel.y / cell.y;
    return row_mask[row] != 0 &&
           mask[std::size_t(row) * std::size_t(size.x) + std::size_t(voxel.x / cell.x)] == kForeignCell;
  }
};

inline SurroundingsView view(const Surroundings& surroundings) {
  return {surroundings.cell, surroundings.size, surroundings.mask.data(), surroundings.row_mask.data()};
}

/// Nearest skin of a voxel: its displacement, and whether it is farther away than the blur.
struct NearSkin {
  bool is_found = false, is_beyond = false;
  Vec3 shift;  // [voxels of the CT]

  TURGOR_HD bool has_hardly_moved() const { return is_found && dot(shift, shift) < 1; }
};

/// Flags of a voxel: it shows body at rest, a voxel near it does.
struct RestCoverage {
  bool own = false, near = false;
};

/// Classifies voxels without tissue as partial volume or surroundings, and computes their values.
struct OutsideVoxel {
  RestBodyView rest;
  SurroundingsView surroundings;
  OutputToCt to_ct;
  CtSampler sample;    // of the CT
  Int3 size;           // of the CT
  bool same;           // the output has the grid of the CT
  std::int16_t dense;  // threshold above which a voxel is not air [HU]

  /// Value of voxel `p`. Partial volume within reach moves with the nearest skin. Voxels that it or the body
  /// left become air. All others keep their value.
  TURGOR_HD std::int16_t operator()(Int3 p, std::size_t voxel, RestCoverage was, NearSkin skin) const {
    const bool has_hardly_moved = skin.has_hardly_moved();
    if (skin.is_beyond && !(was.near && has_hardly_moved)) skin.is_found = false;
    // far from the body
    if (same && !was.near && !skin.is_found) return sample.samples[voxel];
    const Vec3d at = to_ct(p);
    const float unmoved = sample(Vec3(at));
    // surroundings
    if (!(was.near || skin.is_found) || !(was.own || is_partial_volume(at, unmoved)))
      return std::int16_t(lrintf(unmoved));
    // value from which the partial volume moved
    const Vec3d before = at + (skin.is_found ? Vec3d(skin.shift) : Vec3d{});
    const float moved = sample(Vec3(before));
    const bool from_partial_volume = is_partial_volume(before, moved);
    float value = was.near ? float(kAirHu) : unmoved;
    if (skin.is_found && from_partial_volume && !is_tissue(before, moved)) value = moved;
    if (!from_partial_volume && !was.own && has_hardly_moved) value = unmoved;  // cover of a table
    return std::int16_t(lrintf(value));
  }

 private:
  TURGOR_HD int at_ct(Int3 p) const {
    return sample.samples[std::size_t(p.z) * sample.layer + std::size_t(p.y) * sample.row + std::size_t(p.x)];
  }
  /// True if a position outside the body moves with the skin. Air does, and so does skin thinner than half a
  /// block. A table does not.
  TURGOR_HD bool is_partial_volume(Vec3d at, float value) const {
    return value < float(dense) || is_thin_skin(at);
  }

  /// True for the tissue of the body. Its blur may begin one voxel inside its cells.
  TURGOR_HD bool is_tissue(Vec3d at, float value) const {
    if (!rest.holds(at)) return false;
    if (value >= float(dense)) return true;
    for (int axis = 0; axis < 3; axis++) {
      const Vec3d offset{double(axis == 0), double(axis == 1), double(axis == 2)};
      if (!rest.holds(at + offset) || !rest.holds(at - offset)) return false;
    }
    return true;
  }
  TURGOR_HD bool is_thin_skin(Vec3d at) const {
    constexpr int kReach = 2;
    const Int3 p{int(lrint(at.x)), int(lrint(at.y)), int(lrint(at.z))}, last = size - Int3{1, 1, 1};
    if (!(p == min(max(p, Int3{0, 0, 0}), last)) || surroundings.holds(p)) return false;
    const Int3 low = max(p - Int3{kReach, kReach, kReach}, Int3{0, 0, 0}),
               high = min(p + Int3{kReach, kReach, kReach}, last);
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++)
          if (at_ct({i, j, k}) >= dense && rest.holds(Vec3d(Int3{i, j, k}))) return true;
    return false;
  }
};

OutsideVoxel outside_voxel(const CtVolume& ct, double air_max, const Grid& out, const RestBodyView& rest,
                           const SurroundingsView& surroundings);

/// Width of a scanner's blur [voxels of the CT].
constexpr double kBlur = 3;
/// Extra rings beyond the blur. They record whether the skin moved by less than a voxel of the CT; such skin
/// has not left [voxels of the output].
constexpr int kExtraRings = 2;
/// Upper bound of the width of the partial volume [voxels of the output].
constexpr int kMaxReach = 16;
/// Width of the blur [voxels of the output].
int blur_reach(const Grid& out, const Grid& ct);

}  // namespace turgor::lattice

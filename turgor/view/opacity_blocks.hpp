// Coarse opacity of a volume for the ray caster. It marks blocks of samples without visible values and their
// distance to the next visible block (empty-space skipping), and holds the mean opacity of neighborhoods
// (hollows are darkened).
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/view/transfer.hpp"

namespace turgor {

constexpr int kBlock = 4;         // samples along a block's edge
constexpr int kLevels = 4;        // of occupancy
constexpr float kFaint = 0.024f;  // values that hide less than this within the smallest spacing are clouds

/// One value per block of the level; level 0 has blocks of kBlock samples, each further level doubles the
/// edge.
struct OccupancyLevel {
  Int3 size;
  std::vector<float> opaque;  // mean opacity of the block, 0…1
};

struct OpacityBlocks {
  Int3 size;
  std::vector<std::uint8_t>
      distance;                     // blocks to the nearest visible one, maximum over the axes; 0 = visible
  std::vector<std::uint8_t> faint;  // 1 = all values of the block are at most clouds
  std::vector<OccupancyLevel> levels;
};

/// The blocks in host or device memory.
struct OccupancyView {
  Int3 size;
  const float* opaque;
};
struct OpacityBlocksView {
  Int3 size;
  const std::uint8_t *distance, *faint;
  OccupancyView levels[kLevels];
};
OpacityBlocksView view(const OpacityBlocks& blocks);

/// Constants while blocks are built.
struct OpacityOfSamples {
  TransferView transfer;
  float faint_extinction;  // [1/m]
  double depth;            // of a block [m]

  OpacityOfSamples(const TransferView& of, const Grid& grid);
  /// Opacity of a block with this value throughout, 0…1.
  TURGOR_HD float operator()(int hu) const { return float(1 - std::exp(-transfer.extinction(hu) * depth)); }
};

/// The volume must have samples. Interpolated values between the samples of a block count as visible too.
OpacityBlocks build_opacity_blocks(const Exec& exec, const CtVolume& ct, const Transfer& transfer);

TURGOR_HD inline std::size_t block_index(Int3 size, int i, int j, int k) {
  return (std::size_t(k) * std::size_t(size.y) + std::size_t(j)) * std::size_t(size.x) + std::size_t(i);
}

/// Mean opacity at an index, interpolated between blocks, 0 outside.
TURGOR_HD inline float occupancy_at(const OccupancyView& level, int level_number, Vec3 index) {
  const float edge = float(kBlock << level_number);
  const Vec3 position{(index.x + 0.5f) / edge - 0.5f, (index.y + 0.5f) / edge - 0.5f,
                      (index.z + 0.5f) / edge - 0.5f};
  const Int3 low{int(std::floor(position.x)), int(std::floor(position.y)), int(std::floor(position.z))};
  const Vec3 f = position - Vec3(low);
  float sum = 0;
  for (int corner = 0; corner < 8; corner++) {
    const int bx = corner & 1, by = corner >> 1 & 1, bz = corner >> 2;
    const int i = low.x + bx, j = low.y + by, k = low.z + bz;
    if (i < 0 || j < 0 || k < 0 || i >= level.size.x || j >= level.size.y || k >= level.size.z) continue;
    sum += (bx ? f.x : 1 - f.x) * (by ? f.y : 1 - f.y) * (bz ? f.z : 1 - f.z) *
           level.opaque[block_index(level.size, i, j, k)];
  }
  return sum;
}
inline float occupancy_at(const OccupancyLevel& level, int level_number, Vec3 index) {
  return occupancy_at(OccupancyView{level.size, level.opaque.data()}, level_number, index);
}

}  // namespace turgor

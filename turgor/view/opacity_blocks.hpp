// A coarse picture of a volume's opacity, for the ray-caster: in which blocks of samples nothing is visible
// and how far the next visible block is (rays leap over the rest), and how much of its neighbourhood is
// opaque (what lies in a hollow is darker).
#pragma once

#include <cstdint>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/view/transfer.hpp"

namespace turgor {

constexpr int kBlock = 4;         // samples along a block's edge
constexpr float kFaint = 0.024f;  // what hides less within the smallest spacing is a cloud

/// One value a block of the level; level 0 has blocks of kBlock samples, every further one of twice the edge.
struct OccupancyLevel {
  Int3 size;
  std::vector<float> opaque;  // mean opacity of the block, 0…1
};

struct OpacityBlocks {
  Int3 size;
  std::vector<std::uint8_t>
      distance;  // blocks to the nearest visible one, in the largest of three directions; 0 = visible
  std::vector<std::uint8_t> faint;  // 1 = nothing in the block is more than a cloud
  std::vector<OccupancyLevel> levels;
};

/// The volume must have samples. Values between the samples of a block count as visible too.
OpacityBlocks build_opacity_blocks(const Exec& exec, const CtVolume& ct, const Transfer& transfer);

/// Mean opacity around an index, between blocks, 0 outside.
float occupancy_at(const OccupancyLevel& level, int level_number, Vec3 index);

}  // namespace turgor

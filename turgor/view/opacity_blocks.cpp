#include "turgor/view/opacity_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace turgor {

namespace {

int block_count(int samples, int edge) { return (samples + edge - 1) / edge; }

// One row of blocks. Blocks share border samples with the next one, as interpolation does.
struct ClassifyRow {
  const CtVolume& ct;
  const Transfer& transfer;
  const std::vector<float>& opacity;  // of one sample, by HU + 32768
  float faint_extinction;             // [1/m]
  OpacityBlocks& blocks;

  void operator()(std::size_t row) const {
    const Int3 n = ct.grid.size;
    const int j0 = int(row) % blocks.size.y * kBlock, k0 = int(row) / blocks.size.y * kBlock;
    const int j1 = std::min(j0 + kBlock, n.y - 1), k1 = std::min(k0 + kBlock, n.z - 1);
    // range of the values at each i over the rows of the blocks
    std::vector<std::int16_t> low(std::size_t(n.x), INT16_MAX), high(std::size_t(n.x), INT16_MIN);
    for (int k = k0; k <= k1; k++) {
      for (int j = j0; j <= j1; j++) {
        const std::int16_t* samples = &ct.samples[sample_index(ct.grid, 0, j, k)];
        for (std::size_t i = 0; i < std::size_t(n.x); i++) {
          low[i] = std::min(low[i], samples[i]);
          high[i] = std::max(high[i], samples[i]);
        }
      }
    }
    // classify the blocks by their range of values
    for (int b = 0; b < blocks.size.x; b++) {
      const int i0 = b * kBlock, i1 = std::min(i0 + kBlock, n.x - 1);
      const int least = *std::min_element(&low[std::size_t(i0)], &low[std::size_t(i1)] + 1);
      const int most = *std::max_element(&high[std::size_t(i0)], &high[std::size_t(i1)] + 1);
      const bool visible = transfer.is_visible(least, most);
      const std::size_t index = row * std::size_t(blocks.size.x) + std::size_t(b);
      blocks.distance[index] = visible ? 0 : UINT8_MAX;
      blocks.faint[index] = transfer.most_extinction(least, most) < faint_extinction;
      blocks.levels[0].opaque[index] = visible ? mean_opacity({i0, j0, k0}) : 0;
    }
  }

  // every second sample along each axis suffices for a mean
  float mean_opacity(Int3 first) const {
    const Int3 n = ct.grid.size;
    float sum = 0;
    int count = 0;
    for (int k = first.z; k < std::min(first.z + kBlock, n.z); k += 2)
      for (int j = first.y; j < std::min(first.y + kBlock, n.y); j += 2)
        for (int i = first.x; i < std::min(first.x + kBlock, n.x); i += 2, count++)
          sum += opacity[std::size_t(ct.at(i, j, k) + 32768)];
    return sum / float(count);
  }
};

// Chessboard distance to the nearest visible block: one forward and one backward sweep over the 13 preceding
// neighbors.
void spread_distance(Int3 size, std::vector<std::uint8_t>& distance) {
  const int count = size.x * size.y * size.z;
  for (const int sign : {1, -1}) {
    for (int n = 0; n < count; n++) {
      const int index = sign > 0 ? n : count - 1 - n;
      const int i = index % size.x, j = index / size.x % size.y, k = index / (size.x * size.y);
      int best = distance[std::size_t(index)];
      if (best == 0) continue;
      for (int neighbor = 0; neighbor < 13 && best > 1; neighbor++) {
        const int u = i + sign * (neighbor % 3 - 1), v = j + sign * (neighbor / 3 % 3 - 1),
                  w = k + sign * (neighbor / 9 - 1);
        if (u < 0 || v < 0 || w < 0 || u >= size.x || v >= size.y || w >= size.z) continue;
        best = std::min(best, distance[block_index(size, u, v, w)] + 1);
      }
      distance[std::size_t(index)] = std::uint8_t(best);
    }
  }
}

OccupancyLevel half_resolution(const OccupancyLevel& fine) {
  OccupancyLevel coarse{{(fine.size.x + 1) / 2, (fine.size.y + 1) / 2, (fine.size.z + 1) / 2}, {}};
  coarse.opaque.resize(block_index(coarse.size, 0, 0, coarse.size.z));
  for (int k = 0; k < fine.size.z; k++)
    for (int j = 0; j < fine.size.y; j++)
      for (int i = 0; i < fine.size.x; i++)
        coarse.opaque[block_index(coarse.size, i / 2, j / 2, k / 2)] +=
            fine.opaque[block_index(fine.size, i, j, k)] / 8;
  return coarse;
}

}  // namespace

OpacityBlocks build_opacity_blocks(const Exec& exec, const CtVolume& ct, const Transfer& transfer) {
  const Int3 n = ct.grid.size;
  OpacityBlocks blocks;
  blocks.size = {block_count(n.x, kBlock), block_count(n.y, kBlock), block_count(n.z, kBlock)};
  const std::size_t count = block_index(blocks.size, 0, 0, blocks.size.z);
  blocks.distance.resize(count);
  blocks.faint.resize(count);
  blocks.levels.push_back({blocks.size, std::vector<float>(count)});

  const OpacityOfSamples opacity_of(transfer.view(), ct.grid);
  std::vector<float> opacity(65536);
  for (int hu = -32768; hu < 32768; hu++) opacity[std::size_t(hu + 32768)] = opacity_of(hu);
  parallel_for(exec, std::size_t(blocks.size.y) * std::size_t(blocks.size.z),
               ClassifyRow{ct, transfer, opacity, opacity_of.faint_extinction, blocks});
  spread_distance(blocks.size, blocks.distance);
  while (int(blocks.levels.size()) < kLevels) blocks.levels.push_back(half_resolution(blocks.levels.back()));
  return blocks;
}

OpacityOfSamples::OpacityOfSamples(const TransferView& of, const Grid& grid)
    : transfer(of), depth(kBlock * std::cbrt(sample_volume(grid))) {
  const Vec3d spacing = grid.spacing;
  faint_extinction = float(-std::log(1 - double(kFaint)) / std::min({spacing.x, spacing.y, spacing.z}));
}

OpacityBlocksView view(const OpacityBlocks& blocks) {
  OpacityBlocksView v{blocks.size, blocks.distance.data(), blocks.faint.data(), {}};
  for (std::size_t n = 0; n < blocks.levels.size(); n++)
    v.levels[n] = {blocks.levels[n].size, blocks.levels[n].opaque.data()};
  return v;
}

}  // namespace turgor

// Volume rendering as kernels over plain pointers: smoothed values and opacity blocks of a volume, then
// pixels. One thread per value, in any order. The results equal those of smooth_half and
// build_opacity_blocks, which are faster on a CPU. The CPU draws with the same pixel kernels
// (volume_view.cpp).
#pragma once

#include <cstdlib>

#include "turgor/core/box_index.hpp"
#include "turgor/core/run.hpp"
#include "turgor/view/ray_caster.hpp"

namespace turgor {

TURGOR_HD inline std::size_t count_of(Int3 size) { return block_index(size, 0, 0, size.z); }

/// Mean of 2 × 2 × 2 samples; border samples are repeated.
struct HalveSample {
  Samples ct;
  Int3 size;  // size of the result
  std::int16_t* half;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 p = box_index(size, n), last = ct.size - Int3{1, 1, 1};
    int sum = 0;
    for (int corner = 0; corner < 8; corner++) {
      const Int3 at =
          min(Int3{2 * p.x + (corner & 1), 2 * p.y + (corner >> 1 & 1), 2 * p.z + (corner >> 2)}, last);
      sum += *ct.at(at.x, at.y, at.z);
    }
    half[n] = std::int16_t(sum / 8);
  }
};

/// Weights 1 2 1 along all three axes.
struct SmoothSample {
  Samples in;
  std::int16_t* out;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 p = box_index(in.size, n), last = in.size - Int3{1, 1, 1};
    int sum = 0;
    for (int around = 0; around < 27; around++) {
      const Int3 offset{around % 3 - 1, around / 3 % 3 - 1, around / 9 - 1};
      const Int3 at = min(max(p + offset, Int3{0, 0, 0}), last);
      sum += (2 - std::abs(offset.x)) * (2 - std::abs(offset.y)) * (2 - std::abs(offset.z)) *
             *in.at(at.x, at.y, at.z);
    }
    out[n] = std::int16_t(sum / 64);
  }
};

/// Buffers for the blocks of a volume.
struct BlockBuffers {
  Int3 size[kLevels];
  std::uint8_t *distance, *spread, *faint;
  float* opaque[kLevels];

  /// Valid once the blocks are built.
  OpacityBlocksView view() const {
    OpacityBlocksView v{size[0], spread, faint, {}};
    for (int n = 0; n < kLevels; n++) v.levels[n] = {size[n], opaque[n]};
    return v;
  }
};

struct ClassifyBlock {
  Samples ct;
  OpacityOfSamples opacity;
  BlockBuffers blocks;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 first = box_index(blocks.size[0], n) * kBlock;
    const Int3 last = min(first + Int3{kBlock, kBlock, kBlock}, ct.size - Int3{1, 1, 1});
    int least = 32767, most = -32768;
    for (int k = first.z; k <= last.z; k++)
      for (int j = first.y; j <= last.y; j++)
        for (int i = first.x; i <= last.x; i++) {
          const int hu = *ct.at(i, j, k);
          least = hu < least ? hu : least, most = hu > most ? hu : most;
        }
    const bool visible = opacity.transfer.is_visible(least, most);
    blocks.distance[n] = visible ? 0 : 255;
    blocks.faint[n] = opacity.transfer.most_extinction(least, most) < opacity.faint_extinction;
    blocks.opaque[0][n] = visible ? mean_opacity(first) : 0;
  }
  TURGOR_HD float mean_opacity(Int3 first) const {
    const Int3 end = min(first + Int3{kBlock, kBlock, kBlock}, ct.size);
    float sum = 0;
    int count = 0;
    for (int k = first.z; k < end.z; k += 2)
      for (int j = first.y; j < end.y; j += 2)
        for (int i = first.x; i < end.x; i += 2, count++) sum += opacity(*ct.at(i, j, k));
    return sum / float(count);
  }
};

/// One axis of the chessboard distance: minimum over the shifts of the larger of both distances.
struct SpreadDistance {
  Int3 size;
  int axis;
  const std::uint8_t* from;
  std::uint8_t* to;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 p = box_index(size, n);
    const auto step = std::ptrdiff_t(axis == 0 ? 1 : axis == 1 ? size.x : size.x * size.y);
    int best = from[n];
    for (int d = 1; d < best; d++)
      for (const int shift : {-d, d}) {
        const int at = p[axis] + shift;
        if (at < 0 || at >= size[axis]) continue;
        const int other = from[std::ptrdiff_t(n) + shift * step], larger_distance = other > d ? other : d;
        best = larger_distance < best ? larger_distance : best;
      }
    to[n] = std::uint8_t(best);
  }
};

/// A block of the next level: the mean of its eight blocks.
struct HalveOccupancy {
  OccupancyView fine;
  Int3 size;
  float* coarse;

  TURGOR_HD void operator()(std::size_t n) const {
    const Int3 first = box_index(size, n) * 2, end = min(first + Int3{2, 2, 2}, fine.size);
    float sum = 0;
    for (int k = first.z; k < end.z; k++)
      for (int j = first.y; j < end.y; j++)
        for (int i = first.x; i < end.x; i++) sum += fine.opaque[block_index(fine.size, i, j, k)] / 8;
    coarse[n] = sum;
  }
};

template <class Run>
void smooth_with(const Run& run, const Samples& ct, Int3 half_size, std::int16_t* half,
                 std::int16_t* smooth) {
  run(count_of(half_size), HalveSample{ct, half_size, half});
  run(count_of(half_size), SmoothSample{{half, half_size}, smooth});
}

template <class Run>
void build_blocks_with(const Run& run, const Samples& ct, const OpacityOfSamples& opacity,
                       const BlockBuffers& b) {
  const std::size_t count = count_of(b.size[0]);
  run(count, ClassifyBlock{ct, opacity, b});
  run(count, SpreadDistance{b.size[0], 0, b.distance, b.spread});
  run(count, SpreadDistance{b.size[0], 1, b.spread, b.distance});
  run(count, SpreadDistance{b.size[0], 2, b.distance, b.spread});
  for (int n = 1; n < kLevels; n++)
    run(count_of(b.size[n]), HalveOccupancy{{b.size[n - 1], b.opaque[n - 1]}, b.size[n], b.opaque[n]});
}

/// Pixels in tiles, so that neighbors are close in memory.
struct PixelTiles {
  static constexpr int kSide = 16, kPixels = kSide * kSide;
  int width, height;

  TURGOR_HD int columns() const { return (width + kSide - 1) / kSide; }
  std::size_t count() const {
    return std::size_t(columns()) * std::size_t((height + kSide - 1) / kSide) * kPixels;
  }
  /// Pixel of index n; false if it is outside the picture.
  TURGOR_HD bool pixel(std::size_t n, int& x, int& y) const {
    const int tile = int(n / kPixels), in_tile = int(n % kPixels);
    x = tile % columns() * kSide + in_tile % kSide, y = tile / columns() * kSide + in_tile / kSide;
    return x < width && y < height;
  }
};

/// One ray per pixel.
struct DrawPixel {
  RayCaster caster;
  Rgb* image;

  TURGOR_HD void operator()(std::size_t n) const {
    int x, y;
    if (!PixelTiles{caster.width, caster.height}.pixel(n, x, y)) return;
    image[std::size_t(y) * std::size_t(caster.width) + std::size_t(x)] =
        screen_color(caster.pixel(float(x) + 0.5f, float(y) + 0.5f));
  }
};

/// Traces edge pixels again with four rays.
struct DrawEdge {
  RayCaster caster;
  const Rgb* first;
  Rgb* image;

  TURGOR_HD void operator()(std::size_t n) const {
    int x, y;
    if (!PixelTiles{caster.width, caster.height}.pixel(n, x, y)) return;
    Rgb& pixel = image[std::size_t(y) * std::size_t(caster.width) + std::size_t(x)];
    pixel = at(x, y);
    if (!is_edge(x, y)) return;
    const float u[] = {0.375f, 0.875f, 0.625f, 0.125f}, v[] = {0.125f, 0.375f, 0.875f, 0.625f};
    Vec3 sum;
    for (int ray = 0; ray < 4; ray++) sum += caster.pixel(float(x) + u[ray], float(y) + v[ray]);
    pixel = screen_color(sum / 4);
  }

 private:
  TURGOR_HD Rgb at(int x, int y) const {
    return first[std::size_t(y) * std::size_t(caster.width) + std::size_t(x)];
  }
  TURGOR_HD bool is_edge(int x, int y) const {
    const Rgb own = at(x, y);
    return (x > 0 && differs(own, at(x - 1, y))) || (x + 1 < caster.width && differs(own, at(x + 1, y))) ||
           (y > 0 && differs(own, at(x, y - 1))) || (y + 1 < caster.height && differs(own, at(x, y + 1)));
  }
  TURGOR_HD static bool differs(Rgb a, Rgb b) {
    constexpr int kContrast = 14;  // difference of two neighbors in a color byte that makes an edge
    return std::abs(a.r - b.r) > kContrast || std::abs(a.g - b.g) > kContrast ||
           std::abs(a.b - b.b) > kContrast;
  }
};

/// `first` and `image`: width · height.
template <class Run>
void draw_with(const Run& run, const RayCaster& caster, Rgb* first, Rgb* image) {
  const std::size_t count = PixelTiles{caster.width, caster.height}.count();
  run(count, DrawPixel{caster, first}, PixelTiles::kPixels);
  run(count, DrawEdge{caster, first, image}, PixelTiles::kPixels);
}

}  // namespace turgor

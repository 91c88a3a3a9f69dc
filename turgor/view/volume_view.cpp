// Pixels on edges are traced again with four rays.
#include "turgor/view/volume_view.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/view/color.hpp"
#include "turgor/view/opacity_blocks.hpp"
#include "turgor/view/ray_caster.hpp"
#include "turgor/view/smooth.hpp"

namespace turgor {

namespace {

constexpr int kTile = 16;          // pixels
constexpr int kEdgeContrast = 14;  // of two neighbouring pixels, in a colour byte, that makes an edge

bool differs(Rgb a, Rgb b) {
  return std::abs(a.r - b.r) > kEdgeContrast || std::abs(a.g - b.g) > kEdgeContrast ||
         std::abs(a.b - b.b) > kEdgeContrast;
}

bool is_edge(const Image& image, int x, int y) {
  const Rgb here = image.at(x, y);
  return (x > 0 && differs(here, image.at(x - 1, y))) ||
         (x + 1 < image.width && differs(here, image.at(x + 1, y))) ||
         (y > 0 && differs(here, image.at(x, y - 1))) ||
         (y + 1 < image.height && differs(here, image.at(x, y + 1)));
}

template <class PixelKernel>
void for_each_pixel(const Exec& exec, int width, int height, const PixelKernel& kernel) {
  const int columns = (width + kTile - 1) / kTile, rows = (height + kTile - 1) / kTile;
  parallel_for(exec, std::size_t(columns * rows), [&](std::size_t tile) {
    const int left = int(tile) % columns * kTile, top = int(tile) / columns * kTile;
    for (int y = top; y < std::min(top + kTile, height); y++)
      for (int x = left; x < std::min(left + kTile, width); x++) kernel(x, y);
  });
}

}  // namespace

Image draw_volume(const Exec& exec, const CtVolume& ct, const std::string& preset, const Camera& camera,
                  int width, int height) {
  const std::span<const TransferPoint> points = transfer_points(preset);
  TURGOR_ASSERT(!points.empty(), "the preset of draw_volume is one of volume_presets()");
  const Transfer transfer(points);
  const OpacityBlocks blocks = build_opacity_blocks(exec, ct, transfer);
  const CtVolume smooth = smooth_half(exec, ct);
  const RayCaster caster = make_ray_caster(ct, smooth, transfer, blocks, camera, width, height);

  Image first = make_image(width, height);
  for_each_pixel(exec, width, height, [&](int x, int y) {
    first.at(x, y) = screen_color(caster.pixel(float(x) + 0.5f, float(y) + 0.5f));
  });
  Image image = first;
  for_each_pixel(exec, width, height, [&](int x, int y) {
    if (!is_edge(first, x, y)) return;
    Vec3 sum;
    for (const auto& [u, v] :
         {std::pair{0.375f, 0.125f}, {0.875f, 0.375f}, {0.625f, 0.875f}, {0.125f, 0.625f}})
      sum += caster.pixel(float(x) + u, float(y) + v);
    image.at(x, y) = screen_color(sum / 4);
  });
  return image;
}

}  // namespace turgor

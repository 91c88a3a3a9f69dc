#include "turgor/view/volume_view.hpp"

#include "turgor/view/opacity_blocks.hpp"
#include "turgor/view/smooth.hpp"
#include "turgor/view/volume_kernels.hpp"

namespace turgor {

Image draw_volume(const Exec& exec, const CtVolume& ct, const std::string& preset, const Camera& camera,
                  int width, int height) {
  const std::span<const TransferPoint> points = transfer_points(preset);
  TURGOR_ASSERT(!points.empty(), "the preset of draw_volume is one of volume_presets()");
  const Transfer transfer(points);
  const OpacityBlocks blocks = build_opacity_blocks(exec, ct, transfer);
  const CtVolume smooth = smooth_half(exec, ct);
  const RayCaster caster = make_ray_caster(ct, smooth, transfer, blocks, camera, width, height);
  Image first = make_image(width, height), image = first;
  draw_with(CpuRun{exec}, caster, first.pixels.data(), image.pixels.data());
  return image;
}

}  // namespace turgor

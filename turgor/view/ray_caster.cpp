#include "turgor/view/ray_caster.hpp"

#include <algorithm>

namespace turgor {

RayCaster make_ray_caster(const CtVolume& ct, const CtVolume& smooth, const Transfer& transfer,
                          const OpacityBlocks& blocks, const Camera& camera, int width, int height) {
  return make_ray_caster(ct.grid, samples_of(ct), samples_of(smooth), transfer.view(), view(blocks), camera,
                         width, height);
}

RayCaster make_ray_caster(const Grid& grid, Samples ct, Samples smooth, TransferView transfer,
                          const OpacityBlocksView& blocks, const Camera& camera, int width, int height) {
  constexpr float kNoise =
      12;  // differences of smoothed neighbors far below this are noise, far above it a surface [HU]
  const Vec3d origin = index_at(grid, {});
  const Mat3d to_index{{index_at(grid, {1, 0, 0}) - origin, index_at(grid, {0, 1, 0}) - origin,
                        index_at(grid, {0, 0, 1}) - origin}};
  const CameraFrame frame = camera_frame(camera);
  const Vec3d spacing = grid.spacing;
  const float step = float(std::min({spacing.x, spacing.y, spacing.z}));
  return {.ct = ct,
          .smooth = smooth,
          .transfer = transfer,
          .blocks = blocks,
          .lights = camera_lights(frame),
          .frame = frame,
          .to_index = to_index,
          .gradient_to_patient = transposed(to_index),
          .eye = index_at(grid, camera.eye),
          .step = step,
          .noise_gradient = kNoise / (2 * step),
          .width = width,
          .height = height};
}

}  // namespace turgor

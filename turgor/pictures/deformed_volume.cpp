#include "turgor/pictures/deformed_volume.hpp"

#include "turgor/view/gpu_volume.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {

Image draw_deformed_volume(const Exec& exec, const LatticeBody& body, const std::string& preset,
                           const Camera& camera, int width, int height) {
  constexpr lattice::ResampleOptions kAlone{.keep_surroundings = false};
  const Grid& grid = body.ct.grid;
  std::optional<Image> there;
  body.state.show_resampled(exec, body.model, body.ct, grid, kAlone, [&](const std::int16_t* samples) {
    const Result<Gpu> gpu = open_gpu();
    if (!gpu) return;
    const std::unique_ptr<VolumeThere> volume = volume_on(*gpu);
    if (!volume->show(samples, grid)) return;
    if (Result<Image> image = volume->draw(preset, camera, width, height)) there = std::move(*image);
  });
  if (there) return std::move(*there);
  return draw_volume(exec, body.state.resample(exec, body.model, body.ct, grid, kAlone).ct, preset, camera,
                     width, height);
}

}  // namespace turgor

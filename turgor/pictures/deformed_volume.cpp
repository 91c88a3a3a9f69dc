#include "turgor/pictures/deformed_volume.hpp"

#include "turgor/view/pictures_there.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {

Image draw_deformed_volume(const Exec& exec, const LatticeBody& body, const std::string& preset,
                           const Camera& camera, int width, int height) {
  constexpr lattice::ResampleOptions kAlone{.keep_surroundings = false};
  const Grid& grid = body.ct.grid;
  if (const auto there = body.state.resample_there(exec, body.model, body.ct, grid, kAlone))
    if (Result<Image> image = PicturesThere().draw(*there, preset, camera, width, height))
      return std::move(*image);
  return draw_volume(exec, body.state.resample(exec, body.model, body.ct, grid, kAlone).ct, preset, camera,
                     width, height);
}

}  // namespace turgor

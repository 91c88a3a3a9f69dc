#include "turgor/pictures/deformed_volume.hpp"

#include <limits>

#include "turgor/view/volume_view.hpp"

namespace turgor {

Result<Image> draw_deformed(const Exec& exec, const DeformedCt& ct, DevicePictures& pictures,
                            const std::string& preset, const Camera& camera, int width, int height) {
  if (ct.device) return pictures.draw(*ct.device, preset, camera, width, height);
  return draw_volume(exec, ct.ct, preset, camera, width, height);
}

Image draw_deformed_volume(const Exec& exec, const LatticeBody& body, const std::string& preset,
                           const Camera& camera, int width, int height) {
  const auto draw = [&](CtTargets targets) {
    constexpr int kAll = std::numeric_limits<int>::max();
    DevicePictures pictures;
    return draw_deformed(exec, make_deformed_ct(exec, body, 0, targets, kAll), pictures, preset, camera,
                         width, height);
  };
  if (Result<Image> image = draw({.host = false, .device = true})) return std::move(*image);
  return draw({.host = true, .device = false}).value();
}

}  // namespace turgor

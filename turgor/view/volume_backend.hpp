// A volume on the other side of a bus, where it is drawn: the deformed CT that a body made there
// (KeptState::resample_there) needs not come here for its picture.
#pragma once

#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/view/camera.hpp"

namespace turgor {

struct VolumeBackend {
  virtual ~VolumeBackend() = default;

  /// What shall be drawn from now on: a CT that goes over, or samples that are there, which stay as they are
  /// until another is shown. Error: the memory that it needs.
  virtual Status show(const CtVolume& ct) = 0;
  virtual Status show(const std::int16_t* there, const Grid& grid) = 0;
  /// draw_volume of it.
  virtual Result<Image> draw(const std::string& preset, const Camera& camera, int width, int height) = 0;
};

}  // namespace turgor

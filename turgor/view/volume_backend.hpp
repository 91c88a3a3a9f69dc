// Volume rendering on a device. A deformed CT that was computed on the device
// (DeviceState::resample_on_device) is rendered without a download.
#pragma once

#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/view/camera.hpp"

namespace turgor {

struct VolumeBackend {
  virtual ~VolumeBackend() = default;

  /// Sets the volume to draw: a CT, which is uploaded, or samples in device memory, which must not change
  /// until another volume is set. Error: memory is short (with the required amount).
  virtual Status show(const CtVolume& ct) = 0;
  virtual Status show(const std::int16_t* device_samples, const Grid& grid) = 0;
  /// draw_volume of the volume.
  virtual Result<Image> draw(const std::string& preset, const Camera& camera, int width, int height) = 0;
};

}  // namespace turgor

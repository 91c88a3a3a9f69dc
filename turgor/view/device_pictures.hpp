// Pictures of deformed CTs that are computed and rendered on a GPU; only the pictures are downloaded.
#pragma once

#include <functional>
#include <memory>

#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/view/volume_backend.hpp"

namespace turgor {

/// Caches the derived data of the last CT, so that a camera move costs only the rays.
class DevicePictures {
 public:
  using MakeVolume = std::function<Result<std::unique_ptr<VolumeBackend>>()>;

  DevicePictures();
  /// With a backend other than a GPU.
  explicit DevicePictures(MakeVolume make) : make_(std::move(make)) {}

  /// draw_volume of the CT. Error: memory is short (with the required amount); then nothing is cached.
  Result<Image> draw(const lattice::DeviceResampled& ct, const std::string& preset, const Camera& camera,
                     int width, int height);

 private:
  Status show(const lattice::DeviceResampled& ct);

  MakeVolume make_;
  std::unique_ptr<VolumeBackend> volume_;
  std::shared_ptr<const lattice::DeviceSamples> shown_;  // data that `volume_` shows
};

}  // namespace turgor

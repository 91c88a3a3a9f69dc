// Pictures of deformed CTs that a body made on a GPU, drawn there: they alone come back.
#pragma once

#include <functional>
#include <memory>

#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/view/volume_backend.hpp"

namespace turgor {

/// Keeps what it made of the last CT: a camera that moves costs rays alone.
class DevicePictures {
 public:
  using MakeVolume = std::function<Result<std::unique_ptr<VolumeBackend>>()>;

  DevicePictures();
  /// On another side of the bus than a GPU's.
  explicit DevicePictures(MakeVolume make) : make_(std::move(make)) {}

  /// draw_volume of it. Error: the memory that it needs; then it keeps nothing.
  Result<Image> draw(const lattice::DeviceResampled& ct, const std::string& preset, const Camera& camera,
                     int width, int height);

 private:
  Status show(const lattice::DeviceResampled& ct);

  MakeVolume make_;
  std::unique_ptr<VolumeBackend> volume_;
  std::shared_ptr<const lattice::DeviceSamples> shown_;  // by `volume_`
};

}  // namespace turgor

#include "turgor/view/device_pictures.hpp"

#include "turgor/view/gpu_volume.hpp"

namespace turgor {

DevicePictures::DevicePictures()
    : make_([]() -> Result<std::unique_ptr<VolumeBackend>> {
        const Result<Gpu> gpu = open_gpu();
        if (!gpu) return gpu.error();
        return volume_on(*gpu);
      }) {}

Status DevicePictures::show(const lattice::DeviceResampled& ct) {
  if (!volume_) {
    Result<std::unique_ptr<VolumeBackend>> made = make_();
    if (!made) return made.error();
    volume_ = std::move(*made);
  }
  if (ct.samples == shown_) return Done{};
  shown_ = ct.samples;
  return volume_->show(shown_->data(), ct.grid);
}

Result<Image> DevicePictures::draw(const lattice::DeviceResampled& ct, const std::string& preset,
                                   const Camera& camera, int width, int height) {
  const Status status = show(ct);
  Result<Image> image = status ? volume_->draw(preset, camera, width, height) : status.error();
  if (!image) volume_.reset(), shown_.reset();
  return image;
}

}  // namespace turgor

#include "turgor/view/pictures_there.hpp"

#include "turgor/view/gpu_volume.hpp"

namespace turgor {

PicturesThere::PicturesThere()
    : make_([]() -> Result<std::unique_ptr<VolumeThere>> {
        const Result<Gpu> gpu = open_gpu();
        if (!gpu) return gpu.error();
        return volume_on(*gpu);
      }) {}

Status PicturesThere::show(const lattice::ResampledThere& ct) {
  if (!volume_) {
    Result<std::unique_ptr<VolumeThere>> made = make_();
    if (!made) return made.error();
    volume_ = std::move(*made);
  }
  if (ct.samples == shown_) return Done{};
  shown_ = ct.samples;
  return volume_->show(shown_->data(), ct.grid);
}

Result<Image> PicturesThere::draw(const lattice::ResampledThere& ct, const std::string& preset,
                                  const Camera& camera, int width, int height) {
  const Status status = show(ct);
  Result<Image> image = status ? volume_->draw(preset, camera, width, height) : status.error();
  if (!image) volume_.reset(), shown_.reset();
  return image;
}

}  // namespace turgor

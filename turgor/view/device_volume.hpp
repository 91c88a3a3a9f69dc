// A volume on a backend, and its pictures by that backend's run. The backend is GpuBackend (gpu_volume.cu),
// or the host in tests. Only the picture is downloaded.
#pragma once

#include "turgor/core/device_arrays.hpp"
#include "turgor/view/volume_backend.hpp"
#include "turgor/view/volume_kernels.hpp"

namespace turgor {

template <class Backend>
class DeviceVolume final : public VolumeBackend {
 public:
  Status show(const CtVolume& ct) override {
    if (!ct_.try_resize(ct.samples.size()))
      return out_of_memory(ct.grid.size, ct.samples.size() * sizeof(std::int16_t));
    ct_.array.upload(ct.samples);
    return show(ct_.data(), ct.grid);
  }
  Status show(const std::int16_t* device_samples, const Grid& grid) override {
    const Int3 n = grid.size;
    samples_ = {device_samples, n}, grid_ = grid, is_new_ = true;
    half_size_ = {(n.x + 1) / 2, (n.y + 1) / 2, (n.z + 1) / 2};
    const std::size_t halves = count_of(half_size_);
    Int3 size{(n.x + kBlock - 1) / kBlock, (n.y + kBlock - 1) / kBlock, (n.z + kBlock - 1) / kBlock};
    const std::size_t blocks = count_of(size);
    bool all = half_.try_resize(halves) && smooth_.try_resize(halves) && distance_.try_resize(blocks) &&
               spread_.try_resize(blocks) && faint_.try_resize(blocks);
    std::size_t bytes = 2 * halves * sizeof(std::int16_t) + 3 * blocks;
    for (int level = 0; level < kLevels; level++) {
      level_size_[level] = size;
      all = all && opaque_[level].try_resize(count_of(size));
      bytes += count_of(size) * sizeof(float);
      size = {(size.x + 1) / 2, (size.y + 1) / 2, (size.z + 1) / 2};
    }
    if (!all) return out_of_memory(n, bytes);
    return Done{};
  }
  Result<Image> draw(const std::string& preset, const Camera& camera, int width, int height) override {
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    if (!(preset == preset_ || put_transfer(preset)) || !first_.try_resize(pixels) ||
        !image_.try_resize(pixels))
      return out_of_memory({width, height, 1}, 2 * pixels * sizeof(Rgb)).error();
    if (is_new_) build();
    const RayCaster caster = make_ray_caster(grid_, samples_, {smooth_.data(), half_size_}, transfer(),
                                             buffers().view(), camera, width, height);
    draw_with(run_, caster, first_.data(), image_.data());
    Image image = make_image(width, height);
    image_.array.download(image.pixels);
    return image;
  }

 private:
  template <class T>
  using List = DeviceList<Backend, T>;

  static Status out_of_memory(Int3 size, std::size_t bytes) {
    return Error{"pictures of " + std::to_string(size.x) + " × " + std::to_string(size.y) + " × " +
                 std::to_string(size.z) + " samples need " + std::to_string(bytes / 1000000 + 1) +
                 " MB of GPU memory, which is not free"};
  }
  bool put_transfer(const std::string& preset) {
    const std::span<const TransferPoint> points = transfer_points(preset);
    TURGOR_ASSERT(!points.empty(), "the preset of a picture is one of volume_presets()");
    const Transfer transfer(points);
    if (!sums_.try_assign(transfer.sums()) || !most_.try_assign(transfer.most()) ||
        !visible_.try_assign(transfer.visible()))
      return false;
    preset_ = preset, is_new_ = true;
    return true;
  }
  TransferView transfer() const { return {sums_.data(), most_.data(), visible_.data()}; }
  BlockBuffers buffers() const {
    BlockBuffers buffers{{}, distance_.data(), spread_.data(), faint_.data(), {}};
    for (int n = 0; n < kLevels; n++) buffers.size[n] = level_size_[n], buffers.opaque[n] = opaque_[n].data();
    return buffers;
  }
  void build() {
    smooth_with(run_, samples_, half_size_, half_.data(), smooth_.data());
    build_blocks_with(run_, samples_, OpacityOfSamples(transfer(), grid_), buffers());
    is_new_ = false;
  }

  typename Backend::Run run_{};
  Samples samples_{};
  Grid grid_;
  bool is_new_ = true;  // smoothed values and blocks belong to another volume or preset
  std::string preset_;
  Int3 half_size_, level_size_[kLevels];
  List<std::int16_t> ct_, half_, smooth_;
  List<std::uint8_t> distance_, spread_, faint_;
  List<float> opaque_[kLevels], most_;
  List<OpticalSum> sums_;
  List<int> visible_;
  List<Rgb> first_, image_;
};

}  // namespace turgor

// Volume rendering on a GPU; skipped without one. The tests of VolumeKernels run the same kernels on the
// host.
#include "turgor/view/gpu_volume.hpp"

#include <gtest/gtest.h>

#include "tests/view/volume_scene.hpp"
#include "turgor/view/transfer.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {
namespace {

// The picture that the GPU draws matches that of the CPU.
TEST(GpuVolume, PictureMatchesCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const CtVolume ct = test::layered_ct({60, 70, 50});
  const std::unique_ptr<VolumeBackend> device = volume_on(*gpu);
  ASSERT_TRUE(device->show(ct));
  for (const std::string& preset : volume_presets())
    for (int turn = 0; turn < 2; turn++) {
      const Camera camera = test::camera_around(turn);
      const Image drawn = device->draw(preset, camera, test::kWidth, test::kHeight).value();
      const Image expected = draw_volume(Exec(2), ct, preset, camera, test::kWidth, test::kHeight);
      long other = 0;
      for (std::size_t p = 0; p < expected.pixels.size(); p++)
        other += test::difference(drawn.pixels[p], expected.pixels[p]) > 3;
      EXPECT_LE(other, long(expected.pixels.size()) / 200)
          << preset << ": fused multiply-adds and exponentials are rounded differently";
    }
}

}  // namespace
}  // namespace turgor

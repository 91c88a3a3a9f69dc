// What needs a GPU; elsewhere it is skipped with a sentence. What it does there, volume_loops tests here.
#include "turgor/view/gpu_volume.hpp"

#include <gtest/gtest.h>

#include "tests/view/volume_scene.hpp"
#include "turgor/view/transfer.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {
namespace {

TEST(gpu_volume, the_picture_drawn_there_is_the_one_drawn_here) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  const CtVolume ct = test::layered_ct({60, 70, 50});
  const std::unique_ptr<VolumeBackend> there = volume_on(*gpu);
  ASSERT_TRUE(there->show(ct));
  for (const std::string& preset : volume_presets())
    for (int turn = 0; turn < 2; turn++) {
      const Camera camera = test::camera_around(turn);
      const Image drawn = there->draw(preset, camera, test::kWidth, test::kHeight).value();
      const Image here = draw_volume(Exec(2), ct, preset, camera, test::kWidth, test::kHeight);
      long other = 0;
      for (std::size_t p = 0; p < here.pixels.size(); p++)
        other += test::difference(drawn.pixels[p], here.pixels[p]) > 3;
      EXPECT_LE(other, long(here.pixels.size()) / 200)
          << preset << ": fused multiply-adds and exponentials round otherwise";
    }
}

}  // namespace
}  // namespace turgor

#include "turgor/window/ct_pictures.hpp"

#include <gtest/gtest.h>

#include "tests/models/host_side.hpp"
#include "tests/window/window_test.hpp"
#include "turgor/view/device_volume.hpp"

namespace turgor {
namespace {

using namespace test;
using CtPicturesTest = WindowTest;

/// A volume that is elsewhere, on the host in place of a GPU.
struct HeldHere final : lattice::DeviceSamples {
  CtVolume ct = block_ct();

  const std::int16_t* data() const override { return ct.samples.data(); }
  void get(std::span<std::int16_t> samples) const override {
    std::copy(ct.samples.begin(), ct.samples.end(), samples.begin());
  }
};

TEST_F(CtPicturesTest, a_volume_that_a_gpu_draws_is_fine_at_once_and_without_room_a_sentence_says_so) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  const auto samples = std::make_shared<const HeldHere>();
  auto ct = std::make_shared<DeformedCt>();
  ct->there = lattice::DeviceResampled{samples->ct.grid, samples, {}};
  VolumePicture picture;
  picture.pictures = DevicePictures([] {
    return Result(std::unique_ptr<VolumeBackend>(new DeviceVolume<lattice::HostSide<lattice::SeededRun<1>>>));
  });
  VolumeWish wish{ct, "bone", window_->viewer().camera, 320, 240};
  for (int n = 0; n < 3; n++) {
    lattice::Bus::over = lattice::Bus::back = 0;
    EXPECT_TRUE(renew(wish, picture));
    picture.coming.wait();
    EXPECT_EQ(lattice::Bus::back, sizeof(Rgb) * 320 * 240) << "the picture alone";
    EXPECT_EQ(lattice::Bus::over > 0, n == 0) << "the preset's tables";
    wish.camera = orbited(wish.camera, 0.05, 0);
    EXPECT_TRUE(renew(wish, picture));
    EXPECT_EQ(picture.image.width, 320);
    picture.coming.wait();
    EXPECT_TRUE(renew(wish, picture));
    EXPECT_FALSE(picture.coming.valid()) << "nothing finer to come";
    wish.camera = orbited(wish.camera, 0.05, 0);
  }
  picture.pictures =
      DevicePictures([]() -> Result<std::unique_ptr<VolumeBackend>> { return Error{"no room"}; });
  EXPECT_TRUE(renew(wish, picture));
  picture.coming.wait();
  const Status status = renew(wish, picture);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "no room");
  EXPECT_FALSE(picture.coming.valid()) << "it is not tried again";
}

}  // namespace
}  // namespace turgor

#include "turgor/window/ct_pictures.hpp"

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/window/window_test.hpp"
#include "turgor/view/device_volume.hpp"

namespace turgor {
namespace {

using namespace test;
using CtPicturesTest = WindowTest;

/// A volume on the device, for which the host stands in.
struct HostSamples final : lattice::DeviceSamples {
  CtVolume ct = block_ct();

  const std::int16_t* data() const override { return ct.samples.data(); }
  void download(std::span<std::int16_t> samples) const override {
    std::copy(ct.samples.begin(), ct.samples.end(), samples.begin());
  }
};

// A volume on the device is drawn at full size at once; missing memory is reported.
TEST_F(CtPicturesTest, DeviceVolumeIsDrawnAtFullSize) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  const auto samples = std::make_shared<const HostSamples>();
  auto ct = std::make_shared<DeformedCt>();
  ct->device = lattice::DeviceResampled{samples->ct.grid, samples, {}};
  VolumePicture picture;
  picture.pictures = DevicePictures([] {
    return Result(
        std::unique_ptr<VolumeBackend>(new DeviceVolume<lattice::HostBackend<lattice::SeededRun<1>>>));
  });
  VolumeRequest request{ct, "bone", window_->viewer().camera, 320, 240};
  for (int n = 0; n < 3; n++) {
    lattice::Transfers::uploaded = lattice::Transfers::downloaded = 0;
    EXPECT_TRUE(renew(request, picture));
    picture.coming.wait();
    EXPECT_EQ(lattice::Transfers::downloaded, sizeof(Rgb) * 320 * 240) << "only the picture";
    EXPECT_EQ(lattice::Transfers::uploaded > 0, n == 0) << "the tables of the preset";
    request.camera = orbited(request.camera, 0.05, 0);
    EXPECT_TRUE(renew(request, picture));
    EXPECT_EQ(picture.image.width, 320);
    picture.coming.wait();
    EXPECT_TRUE(renew(request, picture));
    EXPECT_FALSE(picture.coming.valid()) << "no finer picture is pending";
    request.camera = orbited(request.camera, 0.05, 0);
  }
  picture.pictures =
      DevicePictures([]() -> Result<std::unique_ptr<VolumeBackend>> { return Error{"no memory"}; });
  EXPECT_TRUE(renew(request, picture));
  picture.coming.wait();
  const Status status = renew(request, picture);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "no memory");
  EXPECT_FALSE(picture.coming.valid()) << "it is not tried again";
}

}  // namespace
}  // namespace turgor

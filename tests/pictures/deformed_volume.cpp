// Deformed CT of a body that steps on a device, for which the host stands in: made and drawn on the device.
#include "turgor/pictures/deformed_volume.hpp"

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/models/lattice/cut_ball.hpp"
#include "turgor/core/gpu.hpp"
#include "turgor/view/device_volume.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {
namespace {

using lattice::CutBall;
using lattice::Method;
using lattice::TissueLaw;
using lattice::Transfers;
using Backend = lattice::HostBackend<lattice::SeededRun<1>>;

const Exec kExec(2);
constexpr int kWidth = 120, kHeight = 90, kMaxSize = 20;
constexpr CtTargets kHost{.host = true, .device = false}, kDevice{.host = false, .device = true},
    kBoth{.host = true, .device = true};

DevicePictures pictures_on_host() {
  return DevicePictures([] { return Result(std::unique_ptr<VolumeBackend>(new DeviceVolume<Backend>)); });
}

LatticeBody body_of(const CutBall& ball) {
  LatticeBody body;
  body.ct = ball.ct, body.model = ball.model;
  body.state = ball.state;
  return body;
}
void step(LatticeBody& body) {
  const lattice::Inputs inputs{.gravity = {0.5, 0, -9.81}};
  EXPECT_TRUE(body.state.step(kExec, body.model, inputs, 4e-3).finite);
}
/// A body that has made one step on the device.
LatticeBody device_body(const CutBall& ball) {
  LatticeBody body = body_of(ball);
  body.state.use_backend(lattice::put_on_host<lattice::SeededRun<1>>(body.model));
  step(body);
  return body;
}

/// Camera from above, shifted sideways, that looks at the center of the ball.
Camera camera_of(const Grid& grid, double aside) {
  const Vec3d middle = point_at(grid, Vec3d(grid.size - Int3{1, 1, 1}) * 0.5);
  return {.eye = middle + Vec3d{aside, -0.07, 0.05}, .target = middle};
}

CtVolume download_ct(const DeformedCt& ct) {
  CtVolume now{.grid = ct.device->grid, .samples = {}};
  now.samples.resize(sample_count(now.grid));
  ct.device->samples->download(now.samples);
  return now;
}

// The deformed CT of a body on the device is made and drawn on the device; only pictures are downloaded.
TEST(DeformedVolume, DeviceBodyIsDrawnOnDevice) {
  for (const CutBall& ball : {CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd}),
                              CutBall({}, TissueLaw::kSprings, {4, 3, 2})}) {
    LatticeBody body = device_body(ball);
    Transfers::downloaded = 0;
    const DeformedCt ct = make_deformed_ct(kExec, body, 3, kDevice, kMaxSize);
    const std::size_t status_bytes =
        sizeof(lattice::MovedBits) + lattice::kCounterCount * sizeof(lattice::ResampleCounts);
    EXPECT_EQ(Transfers::downloaded, status_bytes) << "only the status, neither state nor CT";
    ASSERT_TRUE(ct.device);
    EXPECT_TRUE(ct.ct.samples.empty());
    EXPECT_EQ(ct.device->grid, body.ct.grid) << "the resolution of the CT";
    const CtVolume now = download_ct(ct);
    EXPECT_EQ(now.samples,
              body.state.resample(kExec, body.model, body.ct, body.ct.grid, {.keep_surroundings = false})
                  .ct.samples);
    step(body), step(body);  // the picture shows the CT that was made before
    DevicePictures pictures = pictures_on_host();
    for (const double aside : {0.03, -0.04, 0.0}) {
      Transfers::uploaded = Transfers::downloaded = 0;
      const Camera camera = camera_of(body.ct.grid, aside);
      const Image image = draw_deformed(kExec, ct, pictures, "skin", camera, kWidth, kHeight).value();
      EXPECT_EQ(Transfers::downloaded, image.pixels.size() * sizeof(Rgb)) << "only the picture";
      EXPECT_EQ(Transfers::uploaded > 0, aside == 0.03) << "the tables of the preset, once";
      EXPECT_EQ(image.pixels, draw_volume(kExec, now, "skin", camera, kWidth, kHeight).pixels);
      EXPECT_NE(image.pixels, draw_volume(kExec, ball.ct, "skin", camera, kWidth, kHeight).pixels);
    }
  }
}

// The targets and the location of the body determine whether the deformed CT is on host or device.
TEST(DeformedVolume, TargetsSelectHostOrDevice) {
  const CutBall ball({}, TissueLaw::kSolid);
  const LatticeBody on_host = body_of(ball), on_device = device_body(ball);
  const Grid coarse = lattice::resized(ball.ct.grid, {kMaxSize, kMaxSize, kMaxSize});
  for (const CtTargets targets : {kHost, kDevice, kBoth}) {
    const DeformedCt ct = make_deformed_ct(kExec, on_host, 3, targets, kMaxSize);
    EXPECT_FALSE(ct.device);
    EXPECT_EQ(ct.ct.samples, resample_ct(kExec, on_host.model, on_host.state, on_host.ct, coarse,
                                         {.keep_surroundings = false})
                                 .ct.samples);
    EXPECT_TRUE(ct.covers(targets));
  }
  for (const CtTargets targets : {kHost, kBoth}) {
    const DeformedCt ct = make_deformed_ct(kExec, on_device, 3, targets, kMaxSize);
    EXPECT_EQ(ct.device.has_value(), targets.device);
    EXPECT_EQ(ct.ct.grid, coarse);
    EXPECT_EQ(ct.ct.samples.size(), sample_count(coarse));
  }
  const DeformedCt device_only = make_deformed_ct(kExec, on_device, 3, kDevice, kMaxSize),
                   both = make_deformed_ct(kExec, on_device, 3, kBoth, kMaxSize);
  EXPECT_FALSE(device_only.covers(kBoth));
  EXPECT_FALSE(device_only.covers(kHost));
  EXPECT_TRUE(both.covers(kDevice));
  EXPECT_FALSE(both.covers(kHost)) << "a GPU without memory for a picture is not tried again";
}

// Without device memory for a picture, drawing fails with a message and a run draws on the host.
TEST(DeformedVolume, FallsBackToHostDrawing) {
  const CutBall ball({});
  const LatticeBody body = device_body(ball);
  const Camera camera = camera_of(body.ct.grid, 0.03);
  DevicePictures pictures([]() -> Result<std::unique_ptr<VolumeBackend>> { return Error{"no memory"}; });
  const DeformedCt ct = make_deformed_ct(kExec, body, 0, kDevice, kMaxSize);
  const Result<Image> image = draw_deformed(kExec, ct, pictures, "skin", camera, kWidth, kHeight);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().message, "no memory");
  if (open_gpu()) GTEST_SKIP() << "a GPU would receive host memory";
  const CtVolume now = download_ct(ct);
  EXPECT_EQ(draw_deformed_volume(kExec, body, "skin", camera, kWidth, kHeight).pixels,
            draw_volume(kExec, now, "skin", camera, kWidth, kHeight).pixels);
}

}  // namespace
}  // namespace turgor

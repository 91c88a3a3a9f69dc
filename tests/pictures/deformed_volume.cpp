// A body that steps on another side of the bus, here the host: its deformed CT is made there and drawn there.
#include "turgor/pictures/deformed_volume.hpp"

#include <gtest/gtest.h>

#include "tests/models/host_side.hpp"
#include "tests/models/lattice/cut_ball.hpp"
#include "turgor/core/gpu.hpp"
#include "turgor/view/device_volume.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {
namespace {

using lattice::Bus;
using lattice::CutBall;
using lattice::Method;
using lattice::TissueLaw;
using Side = lattice::HostSide<lattice::SeededRun<1>>;

const Exec kExec(2);
constexpr int kWidth = 120, kHeight = 90, kMost = 20;
constexpr CtWish kHere{.here = true, .there = false}, kThere{.here = false, .there = true},
    kBoth{.here = true, .there = true};

DevicePictures pictures_on_host() {
  return DevicePictures([] { return Result(std::unique_ptr<VolumeBackend>(new DeviceVolume<Side>)); });
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
/// It has stepped there.
LatticeBody body_elsewhere(const CutBall& ball) {
  LatticeBody body = body_of(ball);
  body.state.step_on(lattice::put_on_host<lattice::SeededRun<1>>(body.model));
  step(body);
  return body;
}

/// Of the ball's middle, from aside and above.
Camera camera_of(const Grid& grid, double aside) {
  const Vec3d middle = point_at(grid, Vec3d(grid.size - Int3{1, 1, 1}) * 0.5);
  return {.eye = middle + Vec3d{aside, -0.07, 0.05}, .target = middle};
}

CtVolume fetched(const DeformedCt& ct) {
  CtVolume now{.grid = ct.there->grid, .samples = {}};
  now.samples.resize(sample_count(now.grid));
  ct.there->samples->get(now.samples);
  return now;
}

TEST(DeformedVolume, of_a_body_elsewhere_is_drawn_there_and_a_camera_that_moves_costs_its_picture) {
  for (const CutBall& ball : {CutBall({}, TissueLaw::kSolid), CutBall({.method = Method::kPbd}),
                              CutBall({}, TissueLaw::kSprings, {4, 3, 2})}) {
    LatticeBody body = body_elsewhere(ball);
    Bus::back = 0;
    const DeformedCt ct = make_deformed_ct(kExec, body, 3, kThere, kMost);
    const std::size_t told =
        sizeof(lattice::MovedBits) + lattice::kCountParts * sizeof(lattice::ResampleCounts);
    EXPECT_EQ(Bus::back, told) << "neither the state nor the CT";
    ASSERT_TRUE(ct.there);
    EXPECT_TRUE(ct.ct.samples.empty());
    EXPECT_EQ(ct.there->grid, body.ct.grid) << "the CT's own resolution";
    const CtVolume now = fetched(ct);
    EXPECT_EQ(now.samples,
              body.state.resample(kExec, body.model, body.ct, body.ct.grid, {.keep_surroundings = false})
                  .ct.samples);
    step(body), step(body);  // the picture is that of the CT that was made
    DevicePictures pictures = pictures_on_host();
    for (const double aside : {0.03, -0.04, 0.0}) {
      Bus::over = Bus::back = 0;
      const Camera camera = camera_of(body.ct.grid, aside);
      const Image image = draw_deformed(kExec, ct, pictures, "skin", camera, kWidth, kHeight).value();
      EXPECT_EQ(Bus::back, image.pixels.size() * sizeof(Rgb)) << "the picture alone";
      EXPECT_EQ(Bus::over > 0, aside == 0.03) << "the preset's tables, once";
      EXPECT_EQ(image.pixels, draw_volume(kExec, now, "skin", camera, kWidth, kHeight).pixels);
      EXPECT_NE(image.pixels, draw_volume(kExec, ball.ct, "skin", camera, kWidth, kHeight).pixels);
    }
  }
}

TEST(DeformedVolume, is_made_here_where_it_is_wanted_here_or_the_body_is) {
  const CutBall ball({}, TissueLaw::kSolid);
  const LatticeBody here = body_of(ball), elsewhere = body_elsewhere(ball);
  const Grid coarse = lattice::resized(ball.ct.grid, {kMost, kMost, kMost});
  for (const CtWish wish : {kHere, kThere, kBoth}) {
    const DeformedCt ct = make_deformed_ct(kExec, here, 3, wish, kMost);
    EXPECT_FALSE(ct.there);
    EXPECT_EQ(
        ct.ct.samples,
        resample_ct(kExec, here.model, here.state, here.ct, coarse, {.keep_surroundings = false}).ct.samples);
    EXPECT_TRUE(ct.answers(wish));
  }
  for (const CtWish wish : {kHere, kBoth}) {
    const DeformedCt ct = make_deformed_ct(kExec, elsewhere, 3, wish, kMost);
    EXPECT_EQ(ct.there.has_value(), wish.there);
    EXPECT_EQ(ct.ct.grid, coarse);
    EXPECT_EQ(ct.ct.samples.size(), sample_count(coarse));
  }
  const DeformedCt there = make_deformed_ct(kExec, elsewhere, 3, kThere, kMost),
                   both = make_deformed_ct(kExec, elsewhere, 3, kBoth, kMost);
  EXPECT_FALSE(there.answers(kBoth));
  EXPECT_FALSE(there.answers(kHere));
  EXPECT_TRUE(both.answers(kThere));
  EXPECT_FALSE(both.answers(kHere)) << "a GPU without room for a picture is not asked again";
}

TEST(DeformedVolume, without_room_for_a_picture_a_sentence_says_so_and_a_run_draws_here) {
  const CutBall ball({});
  const LatticeBody body = body_elsewhere(ball);
  const Camera camera = camera_of(body.ct.grid, 0.03);
  DevicePictures pictures([]() -> Result<std::unique_ptr<VolumeBackend>> { return Error{"no room"}; });
  const DeformedCt ct = make_deformed_ct(kExec, body, 0, kThere, kMost);
  const Result<Image> image = draw_deformed(kExec, ct, pictures, "skin", camera, kWidth, kHeight);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().message, "no room");
  if (open_gpu()) GTEST_SKIP() << "a GPU would be given the host's memory";
  const CtVolume now = fetched(ct);
  EXPECT_EQ(draw_deformed_volume(kExec, body, "skin", camera, kWidth, kHeight).pixels,
            draw_volume(kExec, now, "skin", camera, kWidth, kHeight).pixels);
}

}  // namespace
}  // namespace turgor

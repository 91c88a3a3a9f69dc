// Volume rendering by the loops that a GPU runs, in any order, against the picture of the CPU.
#include "turgor/view/volume_kernels.hpp"

#include <gtest/gtest.h>

#include "tests/models/host_side.hpp"
#include "tests/models/lattice/ct_body.hpp"
#include "tests/view/volume_scene.hpp"
#include "turgor/view/device_pictures.hpp"
#include "turgor/view/device_volume.hpp"
#include "turgor/view/smooth.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {
namespace {

using lattice::Bus;
using lattice::HostSide;
using lattice::SeededRun;
using lattice::ThreadedRun;

/// What blocks are made in.
struct BlocksHere {
  OpacityBlocks blocks;
  std::vector<std::uint8_t> distance;
  BlocksRoom room{};

  explicit BlocksHere(const OpacityBlocks& like) : blocks(like), distance(like.distance.size()) {
    room.distance = distance.data(), room.spread = blocks.distance.data(), room.faint = blocks.faint.data();
    for (std::size_t n = 0; n < std::size_t(kLevels); n++) {
      OccupancyLevel& level = blocks.levels[n];
      std::fill(level.opaque.begin(), level.opaque.end(), -1.0f);
      room.size[n] = level.size, room.opaque[n] = level.opaque.data();
    }
    std::fill(blocks.distance.begin(), blocks.distance.end(), std::uint8_t(77));
    std::fill(blocks.faint.begin(), blocks.faint.end(), std::uint8_t(77));
  }
};

template <class Run>
void expect_the_cpus_blocks(const Run& run, const CtVolume& ct, const std::string& preset) {
  const Transfer transfer(transfer_points(preset));
  const OpacityBlocks expected = build_opacity_blocks(Exec(1), ct, transfer);
  BlocksHere made(expected);
  build_blocks_with(run, samples_of(ct), OpacityOfSamples(transfer.view(), ct.grid), made.room);
  EXPECT_EQ(made.blocks.distance, expected.distance) << preset;
  EXPECT_EQ(made.blocks.faint, expected.faint) << preset;
  for (std::size_t n = 0; n < std::size_t(kLevels); n++)
    EXPECT_EQ(made.blocks.levels[n].opaque, expected.levels[n].opaque) << preset << ", level " << n;
}

TEST(volume_loops, build_the_blocks_and_smoothed_values_of_the_cpu_in_any_order) {
  for (const Int3 size : {Int3{33, 40, 26}, {5, 64, 2}, {1, 1, 1}, {90, 4, 4}}) {
    const CtVolume ct = test::layered_ct(size);
    for (const std::string& preset : volume_presets()) {
      expect_the_cpus_blocks(ShuffledRun{1}, ct, preset);
      expect_the_cpus_blocks(ShuffledRun{2}, ct, preset);
      expect_the_cpus_blocks(CpuRun{Exec(8)}, ct, preset);
    }
    const CtVolume expected = smooth_half(Exec(1), ct);
    CtVolume half = expected, smooth = expected;
    smooth_with(ShuffledRun{3}, samples_of(ct), half.grid.size, half.samples.data(), smooth.samples.data());
    EXPECT_EQ(smooth.samples, expected.samples);
  }
}

TEST(volume_loops, of_a_ct_without_anything_to_see_know_no_distance) {
  const CtVolume air = test::fill_volume(test::centered_grid({1100, 4, 4}, {0.001, 0.001, 0.001}, {}),
                                         [](Vec3d) { return -1000.0; });
  expect_the_cpus_blocks(ShuffledRun{1}, air, "bone");
  CtVolume far = air;
  far.at(0, 0, 0) = 1000;
  expect_the_cpus_blocks(ShuffledRun{1}, far, "bone");
}

template <class R>
Image drawn(const CtVolume& ct, const std::string& preset, int turn) {
  DeviceVolume<HostSide<R>> there;
  EXPECT_TRUE(there.show(ct));
  return there.draw(preset, test::camera_around(turn), test::kWidth, test::kHeight).value();
}

TEST(volume_loops, draw_the_picture_of_the_cpu_in_any_order) {
  const CtVolume ct = test::layered_ct({60, 70, 50});
  for (const std::string& preset : volume_presets()) {
    const Image here = draw_volume(Exec(2), ct, preset, test::camera_around(1), test::kWidth, test::kHeight);
    EXPECT_EQ(drawn<SeededRun<1>>(ct, preset, 1).pixels, here.pixels) << preset;
    EXPECT_EQ(drawn<SeededRun<2>>(ct, preset, 1).pixels, here.pixels) << preset;
    EXPECT_EQ(drawn<ThreadedRun<8>>(ct, preset, 1).pixels, here.pixels) << preset;
  }
}

TEST(volume_loops, follow_the_camera_the_preset_and_the_volume_and_bring_the_picture_alone_back) {
  const CtVolume first = test::layered_ct({60, 70, 50}), second = test::layered_ct({41, 33, 64});
  DeviceVolume<HostSide<SeededRun<1>>> there;
  for (const CtVolume* ct : {&first, &second, &first})
    for (const char* preset : {"bone", "skin"}) {
      Bus::over = 0;
      ASSERT_TRUE(there.show(*ct));
      EXPECT_EQ(Bus::over, ct->samples.size() * sizeof(std::int16_t));
      for (int turn = 0; turn < 2; turn++) {
        Bus::over = Bus::back = 0;
        const Image image =
            there.draw(preset, test::camera_around(turn), test::kWidth, test::kHeight).value();
        EXPECT_EQ(Bus::back, image.pixels.size() * sizeof(Rgb));
        EXPECT_EQ(Bus::over > 0, turn == 0) << "the preset's tables";
        EXPECT_EQ(
            image.pixels,
            draw_volume(Exec(2), *ct, preset, test::camera_around(turn), test::kWidth, test::kHeight).pixels);
      }
    }
}

TEST(volume_loops, draw_a_deformed_ct_that_stays_where_it_was_made) {
  using namespace lattice;
  const CtVolume ct = ball_ct(40, 15);
  const Model model = body_of(ct, {4, 4, 4});
  State moved = make_state(model);
  move(model, moved, [](Vec3d x) { return wobble(x, 0.003, 0.04, 0.2); });
  DeviceState state = moved;
  DevicePictures pictures(
      [] { return Result(std::unique_ptr<VolumeBackend>(new DeviceVolume<HostSide<SeededRun<1>>>)); });
  const Vec3d middle = point_at(ct.grid, {19.5, 19.5, 19.5});
  const Camera camera{.eye = middle + Vec3d{0.03, -0.12, 0.05}, .target = middle};
  const ResampleOptions alone{.keep_surroundings = false};
  EXPECT_FALSE(state.resample_there(Exec(1), model, ct, ct.grid, alone)) << "it is here";
  state.step_on(put_on_host<SeededRun<1>>(model));
  EXPECT_TRUE(state.step(Exec(1), model, {}, 1e-4).finite);
  Bus::back = 0;
  const auto made = state.resample_there(Exec(1), model, ct, ct.grid, alone);
  ASSERT_TRUE(made);
  const Image there = pictures.draw(*made, "skin", camera, test::kWidth, test::kHeight).value();
  EXPECT_EQ(Bus::back,
            there.pixels.size() * sizeof(Rgb) + sizeof(MovedBits) + kCountParts * sizeof(ResampleCounts))
      << "the picture, and what is told of the CT";
  const CtVolume now = state.resample(Exec(1), model, ct, ct.grid, alone).ct;
  EXPECT_EQ(there.pixels, draw_volume(Exec(1), now, "skin", camera, test::kWidth, test::kHeight).pixels);
  EXPECT_NE(there.pixels, draw_volume(Exec(1), ct, "skin", camera, test::kWidth, test::kHeight).pixels);
}

/// A side without room for more than so many values.
struct SmallSide {
  static inline std::size_t room = 0;
  template <class T>
  struct Array : lattice::CountedArray<T> {
    Array() = default;
    explicit Array(std::size_t count) : lattice::CountedArray<T>(count <= room ? count : 0), wanted(count) {}
    bool is_allocated() const { return wanted <= room; }
    std::size_t wanted = 0;
  };
  using Run = SeededRun<1>;
};

TEST(volume_loops, without_room_say_what_they_need) {
  const CtVolume ct = test::layered_ct({60, 70, 50});
  DeviceVolume<SmallSide> there;
  SmallSide::room = 1000;
  const Status status = there.show(ct);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("60 × 70 × 50"), std::string::npos) << status.error().message;
  SmallSide::room = 1000000;
  ASSERT_TRUE(there.show(ct));
  EXPECT_TRUE(there.draw("bone", test::camera_around(0), 100, 100));
  EXPECT_FALSE(there.draw("bone", test::camera_around(0), 1100, 1000));
}

}  // namespace
}  // namespace turgor

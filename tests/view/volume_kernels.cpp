// Kernels of volume rendering, run on the host in any order and compared with the picture of the CPU.
#include "turgor/view/volume_kernels.hpp"

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/models/lattice/ct_body.hpp"
#include "tests/view/volume_scene.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/view/device_pictures.hpp"
#include "turgor/view/device_volume.hpp"
#include "turgor/view/smooth.hpp"
#include "turgor/view/volume_view.hpp"

namespace turgor {
namespace {

using lattice::HostBackend;
using lattice::SeededRun;
using lattice::ThreadedRun;
using lattice::Transfers;

/// Buffers in which the kernels build blocks.
struct HostBlocks {
  OpacityBlocks blocks;
  std::vector<std::uint8_t> distance;
  BlockBuffers buffers{};

  explicit HostBlocks(const OpacityBlocks& like) : blocks(like), distance(like.distance.size()) {
    buffers.distance = distance.data(), buffers.spread = blocks.distance.data(),
    buffers.faint = blocks.faint.data();
    for (std::size_t n = 0; n < std::size_t(kLevels); n++) {
      OccupancyLevel& level = blocks.levels[n];
      std::fill(level.opaque.begin(), level.opaque.end(), -1.0f);
      buffers.size[n] = level.size, buffers.opaque[n] = level.opaque.data();
    }
    std::fill(blocks.distance.begin(), blocks.distance.end(), std::uint8_t(77));
    std::fill(blocks.faint.begin(), blocks.faint.end(), std::uint8_t(77));
  }
};

template <class Run>
void expect_cpu_blocks(const Run& run, const CtVolume& ct, const std::string& preset) {
  const Transfer transfer(transfer_points(preset));
  const OpacityBlocks expected = build_opacity_blocks(Exec(1), ct, transfer);
  HostBlocks made(expected);
  build_blocks_with(run, samples_of(ct), OpacityOfSamples(transfer.view(), ct.grid), made.buffers);
  EXPECT_EQ(made.blocks.distance, expected.distance) << preset;
  EXPECT_EQ(made.blocks.faint, expected.faint) << preset;
  for (std::size_t n = 0; n < std::size_t(kLevels); n++)
    EXPECT_EQ(made.blocks.levels[n].opaque, expected.levels[n].opaque) << preset << ", level " << n;
}

// Kernels in any order build the same blocks and smoothed values as the CPU.
TEST(VolumeKernels, BlocksAndSmoothingMatchCpu) {
  for (const Int3 size : {Int3{33, 40, 26}, {5, 64, 2}, {1, 1, 1}, {90, 4, 4}}) {
    const CtVolume ct = test::layered_ct(size);
    for (const std::string& preset : volume_presets()) {
      expect_cpu_blocks(ShuffledRun{1}, ct, preset);
      expect_cpu_blocks(ShuffledRun{2}, ct, preset);
      expect_cpu_blocks(CpuRun{Exec(8)}, ct, preset);
    }
    const CtVolume expected = smooth_half(Exec(1), ct);
    CtVolume half = expected, smooth = expected;
    smooth_with(ShuffledRun{3}, samples_of(ct), half.grid.size, half.samples.data(), smooth.samples.data());
    EXPECT_EQ(smooth.samples, expected.samples);
  }
}

// The blocks of an invisible volume, or of one with a single visible sample, match the CPU.
TEST(VolumeKernels, InvisibleVolumeBlocksMatchCpu) {
  const CtVolume air = test::fill_volume(test::centered_grid({1100, 4, 4}, {0.001, 0.001, 0.001}, {}),
                                         [](Vec3d) { return -1000.0; });
  expect_cpu_blocks(ShuffledRun{1}, air, "bone");
  CtVolume far = air;
  far.at(0, 0, 0) = 1000;
  expect_cpu_blocks(ShuffledRun{1}, far, "bone");
}

template <class R>
Image drawn(const CtVolume& ct, const std::string& preset, int turn) {
  DeviceVolume<HostBackend<R>> device;
  EXPECT_TRUE(device.show(ct));
  return device.draw(preset, test::camera_around(turn), test::kWidth, test::kHeight).value();
}

// Kernels in any order draw the picture of the CPU.
TEST(VolumeKernels, PictureMatchesCpu) {
  const CtVolume ct = test::layered_ct({60, 70, 50});
  for (const std::string& preset : volume_presets()) {
    const Image expected =
        draw_volume(Exec(2), ct, preset, test::camera_around(1), test::kWidth, test::kHeight);
    EXPECT_EQ(drawn<SeededRun<1>>(ct, preset, 1).pixels, expected.pixels) << preset;
    EXPECT_EQ(drawn<SeededRun<2>>(ct, preset, 1).pixels, expected.pixels) << preset;
    EXPECT_EQ(drawn<ThreadedRun<8>>(ct, preset, 1).pixels, expected.pixels) << preset;
  }
}

// New cameras, presets and volumes draw correctly; only pictures are downloaded.
TEST(VolumeKernels, OnlyPictureIsDownloaded) {
  const CtVolume first = test::layered_ct({60, 70, 50}), second = test::layered_ct({41, 33, 64});
  DeviceVolume<HostBackend<SeededRun<1>>> device;
  for (const CtVolume* ct : {&first, &second, &first})
    for (const char* preset : {"bone", "skin"}) {
      Transfers::uploaded = 0;
      ASSERT_TRUE(device.show(*ct));
      EXPECT_EQ(Transfers::uploaded, ct->samples.size() * sizeof(std::int16_t));
      for (int turn = 0; turn < 2; turn++) {
        Transfers::uploaded = Transfers::downloaded = 0;
        const Image image =
            device.draw(preset, test::camera_around(turn), test::kWidth, test::kHeight).value();
        EXPECT_EQ(Transfers::downloaded, image.pixels.size() * sizeof(Rgb));
        EXPECT_EQ(Transfers::uploaded > 0, turn == 0) << "only the tables of the preset";
        EXPECT_EQ(
            image.pixels,
            draw_volume(Exec(2), *ct, preset, test::camera_around(turn), test::kWidth, test::kHeight).pixels);
      }
    }
}

// A deformed CT is drawn on the device where it was made, without downloading it.
TEST(VolumeKernels, DrawsDeformedCtOnDevice) {
  using namespace lattice;
  const CtVolume ct = ball_ct(40, 15);
  const Model model = body_of(ct, {4, 4, 4});
  State moved = make_state(model);
  move(model, moved, [](Vec3d x) { return wobble(x, 0.003, 0.04, 0.2); });
  DeviceState state = moved;
  DevicePictures pictures(
      [] { return Result(std::unique_ptr<VolumeBackend>(new DeviceVolume<HostBackend<SeededRun<1>>>)); });
  const Vec3d middle = point_at(ct.grid, {19.5, 19.5, 19.5});
  const Camera camera{.eye = middle + Vec3d{0.03, -0.12, 0.05}, .target = middle};
  const ResampleOptions alone{.keep_surroundings = false};
  EXPECT_FALSE(state.resample_on_device(Exec(1), model, ct, ct.grid, alone)) << "the state is on the host";
  state.use_backend(put_on_host<SeededRun<1>>(model));
  EXPECT_TRUE(state.step(Exec(1), model, {}, 1e-4).finite);
  Transfers::downloaded = 0;
  const auto made = state.resample_on_device(Exec(1), model, ct, ct.grid, alone);
  ASSERT_TRUE(made);
  const Image drawn_image = pictures.draw(*made, "skin", camera, test::kWidth, test::kHeight).value();
  EXPECT_EQ(Transfers::downloaded, drawn_image.pixels.size() * sizeof(Rgb) + sizeof(MovedBits) +
                                       kCounterCount * sizeof(ResampleCounts))
      << "the picture and the status of resampling";
  const CtVolume now = state.resample(Exec(1), model, ct, ct.grid, alone).ct;
  EXPECT_EQ(drawn_image.pixels,
            draw_volume(Exec(1), now, "skin", camera, test::kWidth, test::kHeight).pixels);
  EXPECT_NE(drawn_image.pixels, draw_volume(Exec(1), ct, "skin", camera, test::kWidth, test::kHeight).pixels);
}

/// A backend without memory for more than `capacity` values per array.
struct SmallBackend {
  static inline std::size_t capacity = 0;
  template <class T>
  struct Array : lattice::CountedArray<T> {
    Array() = default;
    explicit Array(std::size_t count)
        : lattice::CountedArray<T>(count <= capacity ? count : 0), wanted(count) {}
    bool is_allocated() const { return wanted <= capacity; }
    std::size_t wanted = 0;
  };
  using Run = SeededRun<1>;
};

// Without device memory the error states the size of the volume.
TEST(VolumeKernels, ReportsMissingMemory) {
  const CtVolume ct = test::layered_ct({60, 70, 50});
  DeviceVolume<SmallBackend> device;
  SmallBackend::capacity = 1000;
  const Status status = device.show(ct);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("60 × 70 × 50"), std::string::npos) << status.error().message;
  SmallBackend::capacity = 1000000;
  ASSERT_TRUE(device.show(ct));
  EXPECT_TRUE(device.draw("bone", test::camera_around(0), 100, 100));
  EXPECT_FALSE(device.draw("bone", test::camera_around(0), 1100, 1000));
}

}  // namespace
}  // namespace turgor

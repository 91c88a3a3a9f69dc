#include "turgor/view/video.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/small_disk.hpp"
#include "turgor/io/files/image.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

class Video : public testing::Test {
 protected:
  // A name that a shell, or a program that parses names, would misread.
  fs::path folder = fs::temp_directory_path() / ("turgor -video %d 'test'; " + std::to_string(getpid()));

  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  std::vector<fs::path> make_frames(int count, int width = 64, int height = 48) {
    std::vector<fs::path> frames;
    for (int i = 0; i < count; i++) {
      frames.push_back(folder / ("-frame " + std::to_string(i * 10) + ".png"));
      EXPECT_TRUE(write_png(frames.back(), make_image(width, height, {std::uint8_t(20 * i), 90, 200})));
    }
    return frames;
  }
  // Number of files in the folder that are not frames.
  int others() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder)) count += entry.path().extension() != ".png";
    return count;
  }
};

std::string output_of(const std::string& command) {
  std::string text;
  std::array<char, 256> buffer;
  FILE* pipe = popen(command.c_str(), "r");
  while (pipe && std::fgets(buffer.data(), int(buffer.size()), pipe)) text += buffer.data();
  if (pipe) pclose(pipe);
  return text;
}

// The video has one frame per picture.
TEST_F(Video, FrameCountMatchesPictures) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not on the PATH";
  const fs::path path = folder / "out.mp4";
  const Status status = write_video(make_frames(7, 65, 49), 30, path);
  ASSERT_TRUE(status) << status.error().message;
  EXPECT_EQ(others(), 1) << "only the video remains";
  fs::create_symlink(path, "/tmp/turgor-video-" + std::to_string(getpid()) + ".mp4");
  const fs::path plain = "/tmp/turgor-video-" + std::to_string(getpid()) + ".mp4";
  EXPECT_EQ(
      output_of(
          "ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 " +
          plain.string()),
      "66,50,7\n");
  fs::remove(plain);
}

// A missing frame is named in the error, and no file is left.
TEST_F(Video, MissingFrameIsNamed) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not on the PATH";
  std::vector<fs::path> frames = make_frames(2);
  frames.push_back(folder / "gone.png");
  const Status status = write_video(frames, 30, folder / "out.mp4");
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("gone.png"), std::string::npos);
  EXPECT_EQ(others(), 0);
}

// A frame that is no image is an error, and an earlier video is kept.
TEST_F(Video, NonImageFrameFailsAndKeepsOldVideo) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not on the PATH";
  const fs::path broken = folder / "broken.png", path = folder / "out.mp4";
  for (const fs::path& file : {broken, path}) {
    FILE* out = std::fopen(file.c_str(), "w");
    std::fputs("earlier", out);
    std::fclose(out);
  }
  const Status status = write_video({broken}, 30, path);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("ffmpeg failed: "), std::string::npos);
  EXPECT_EQ(fs::file_size(path), 7u);
}

// On a full disk writing fails, and the earlier video is kept.
TEST_F(Video, FullDiskKeepsOldVideo) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not on the PATH";
  std::vector<fs::path> frames;
  std::uint32_t noise = 1;
  for (int i = 0; i < 20; i++) {
    Image image = make_image(160, 120);
    for (Rgb& pixel : image.pixels) pixel.g = std::uint8_t((noise = noise * 1664525u + 1013904223u) >> 24);
    frames.push_back(folder / (std::to_string(i) + ".png"));
    ASSERT_TRUE(write_png(frames.back(), image));
  }
  const fs::path path = folder / "out.mp4";
  ASSERT_TRUE(write_video(frames, 20, path));
  const auto size = fs::file_size(path);
  for (const int percent : {10, 50, 90, 99})
    EXPECT_TRUE(
        test::on_a_small_disk(size * rlim_t(percent) / 100, [&] { return !write_video(frames, 20, path); }))
        << percent << " % of " << size;
  EXPECT_EQ(fs::file_size(path), size);
  EXPECT_EQ(others(), 1);
}

// No frames, a rate of zero and a missing folder are errors.
TEST_F(Video, RejectsInvalidArguments) {
  EXPECT_FALSE(write_video({}, 30, folder / "out.mp4"));
  const std::vector<fs::path> frames = make_frames(1);
  EXPECT_FALSE(write_video(frames, 0, folder / "out.mp4"));
  EXPECT_FALSE(write_video(frames, 30, folder / "no" / "such" / "out.mp4"));
}

// A missing ffmpeg is reported.
TEST_F(Video, MissingFfmpegIsReported) {
  const std::vector<fs::path> frames = make_frames(1);
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder.c_str(), 1);
  const Status status = write_video(frames, 30, folder / "out.mp4");
  setenv("PATH", before.c_str(), 1);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("ffmpeg is not on the PATH"), std::string::npos);
}

/// Puts a program named ffmpeg first on the PATH during its lifetime.
struct FakeFfmpeg {
  std::string before = std::getenv("PATH");
  FakeFfmpeg(const fs::path& folder, const std::string& script) {
    fs::create_directories(folder / "bin");
    std::ofstream(folder / "bin" / "ffmpeg") << "#!/bin/sh\n" << script << "\n";
    fs::permissions(folder / "bin" / "ffmpeg", fs::perms::owner_all);
    setenv("PATH", ((folder / "bin").string() + ":" + before).c_str(), 1);
  }
  ~FakeFfmpeg() { setenv("PATH", before.c_str(), 1); }
};

// Each failure of ffmpeg has its own message and leaves no files.
TEST_F(Video, FfmpegFailuresAreExplained) {
  const std::vector<fs::path> frames = make_frames(2);
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"sleep 1000", "made no progress for 0.5 s"},
      {"trap '' TERM INT ALRM; while :; do sleep 1; done", "made no progress for 0.5 s"},
      {"kill -SEGV $$", "it crashed (Segmentation fault)"},
      {"kill -KILL $$", "it was killed, perhaps because the machine's memory ran out"},
      {"exit 3", "it ended with status 3"},
      {"printf '\\033[31mno\\007 codec\\n' >&2; exit 1", "ffmpeg failed: \uFFFD[31mno\uFFFD codec"},
      {"echo garbage > video.mp4", "its output is not a video"},
      {"exit 0", "its output is not a video"},
      {"cat; exit 4", "it ended with status 4"}};
  for (const auto& [script, sentence] : cases) {
    const FakeFfmpeg fake(folder, script);
    const Status status = write_video(frames, 30, folder / "out.mp4", 0.5);
    ASSERT_FALSE(status) << script;
    EXPECT_NE(status.error().message.find(sentence), std::string::npos) << status.error().message;
    EXPECT_NE(status.error().message.find("out.mp4"), std::string::npos);
    EXPECT_EQ(others(), 1) << "only the folder of the fake ffmpeg remains";
  }
}

// An ffmpeg that reads frames is not stopped, however long it writes nothing.
TEST_F(Video, ReadingFramesIsProgress) {
  const FakeFfmpeg fake(folder,
                        "for n in 1 2 3 4 5; do cat 000000.png >/dev/null; sleep 0.6; done\n"
                        "printf '\\0\\0\\0\\040ftypisom' >video.mp4");
  const Status status = write_video(make_frames(1), 30, folder / "out.mp4", 2);
  EXPECT_TRUE(status) << status.error().message;
}

// An ffmpeg that cannot be started is reported.
TEST_F(Video, UnstartableFfmpegIsReported) {
  const std::vector<fs::path> frames = make_frames(1);
  const FakeFfmpeg fake(folder, "");
  std::ofstream(folder / "bin" / "ffmpeg") << "#!/no/such/shell\n";
  setenv("PATH", (folder / "bin").c_str(), 1);  // otherwise the next ffmpeg on the PATH is tried
  const Status status = write_video(frames, 30, folder / "out.mp4");
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("could not be started"), std::string::npos) << status.error().message;
}

}  // namespace
}  // namespace turgor

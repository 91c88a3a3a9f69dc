// Files that the window opens and writes.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "tests/sim/live/replayed_world.hpp"
#include "tests/window/window_test.hpp"
#include "turgor/view/video.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;
using WindowFilesTest = WindowTest;

// An invalid scene keeps the window open, and R reloads it.
TEST_F(WindowFilesTest, InvalidSceneCanBeReloaded) {
  const fs::path file = folder_ / "mended.toml";
  std::ofstream(file) << "[world]\nduration = -1\n";
  open(file);
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.phase == SessionStatus::Phase::kFailed; }));
  EXPECT_NE(now().error.find("mended.toml:2"), std::string::npos);
  draw_for(0.2);
  fs::copy_file(liver(folder_), file, fs::copy_options::overwrite_existing);
  type("r");
  EXPECT_TRUE(wait_for_world());
}

/// Calls the callback that GLFW calls when files are dropped.
void drop(const fs::path& file) {
  GLFWwindow* window = glfwGetCurrentContext();
  const GLFWdropfun dropped = glfwSetDropCallback(window, nullptr);
  glfwSetDropCallback(window, dropped);
  ASSERT_TRUE(dropped);
  const char* files[] = {file.c_str()};
  dropped(window, 1, files);
}

// A dropped file is opened and framed as a whole.
TEST_F(WindowFilesTest, DroppedFileIsOpenedAndFramed) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const int before = now().world;
  drop(block(folder_));
  ASSERT_TRUE(draw_until([&](const SessionStatus& n) {
    return n.world > before && n.phase == SessionStatus::Phase::kReady && !n.snapshot.bodies.empty();
  }));
  draw_for(0.1);
  EXPECT_EQ(now().snapshot.bodies[0].name, "block");
  const Box box = box_of(now().snapshot);
  for (int i = 0; i < 8; i++) {
    const auto seen = project(window_->viewer().camera, corner(box, i), window_->viewer().area.aspect());
    ASSERT_TRUE(seen);
    EXPECT_LE(std::max(std::abs(seen->x), std::abs(seen->y)), 1.01);
  }
}

/// A sheet of two meters around a position.
fs::path sheet_around(const fs::path& folder, Vec3d position) {
  std::ofstream(folder / "sheet.toml") << fmt::format(R"([world]
duration = 1
[body.sheet]
model = "cloth"
sheet = {{ corner = [{}, {}, {}], side = [2, 0, 0], up = [0, 2, 2], columns = 8, rows = 8 }}
)",
                                                      position.x - 1, position.y - 1, position.z - 1);
  return folder / "sheet.toml";
}

// Another file is opened and framed as a whole, even if it surrounds the last view.
TEST_F(WindowFilesTest, OpenedFileIsFramed) {
  for (const bool around : {false, true}) {
    open(liver(folder_));
    ASSERT_TRUE(wait_for_world());
    const Box before = box_of(now().snapshot);
    open_file(window_->viewer(),  // a drop on the window calls this
              around ? sheet_around(folder_, (before.low + before.high) * 0.5) : block(folder_));
    ASSERT_TRUE(draw_until([&](const SessionStatus& n) {
      return n.phase == SessionStatus::Phase::kReady && !n.snapshot.bodies.empty() &&
             n.snapshot.bodies[0].name != "liver";
    }));
    draw_for(0.1);
    const Box box = box_of(now().snapshot);
    for (int i = 0; i < 8; i++) {
      const auto seen = project(window_->viewer().camera, corner(box, i), window_->viewer().area.aspect());
      ASSERT_TRUE(seen) << "around " << around;
      EXPECT_LE(std::max(std::abs(seen->x), std::abs(seen->y)), 1.01) << "around " << around;
    }
    window_.reset();
  }
}

// A color mode that the next scene does not support is reset.
TEST_F(WindowFilesTest, UnsupportedColorIsReset) {
  const fs::path pad = folder_ / "pad.toml";
  std::ofstream(pad) << R"([world]
duration = 1
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }
fixed = "bottom"
cache = false
)";
  open(pad);
  ASSERT_TRUE(wait_for_world());
  window_->viewer().display.color = SkinColor::kPressure;
  draw_for(0.1);
  EXPECT_EQ(window_->viewer().display.color, SkinColor::kPressure);
  open_file(window_->viewer(), liver(folder_));
  ASSERT_TRUE(draw_until([](const SessionStatus& n) {
    return n.phase == SessionStatus::Phase::kReady && n.snapshot.bodies.size() == 1 &&
           n.snapshot.bodies[0].name == "liver";
  }));
  draw_for(0.1);
  EXPECT_EQ(window_->viewer().display.color, SkinColor::kNone);
}

// Closing the window finishes its video and removes the single pictures.
TEST_F(WindowFilesTest, ClosingFinishesVideo) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  type("v");
  draw_for(0.5);
  EXPECT_TRUE(fs::exists(folder_ / "out" / ".film-1"));
  window_.reset();
  EXPECT_FALSE(fs::exists(folder_ / "out" / ".film-1"));
  EXPECT_EQ(fs::exists(folder_ / "out" / "liver-1.mp4"), has_ffmpeg());
}

// A dropped file that is no scene is reported, and the window stays open.
TEST_F(WindowFilesTest, DroppedNonSceneIsReported) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  std::ofstream(folder_ / "notes.txt") << "no scene";
  drop(folder_ / "notes.txt");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.phase == SessionStatus::Phase::kFailed; }));
  EXPECT_NE(now().error.find("notes.txt"), std::string::npos) << now().error;
  drop(liver(folder_));
  EXPECT_TRUE(wait_for_world());
}

// R reloads a scene that changed on disk.
TEST_F(WindowFilesTest, ReloadsChangedScene) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const std::size_t vertices = now().snapshot.bodies[0].x.size();
  const int world = now().world;
  std::ifstream file(folder_ / "liver.toml");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  text.replace(text.find("detail = 0.5"), 12, "detail = 0.8");
  std::ofstream(folder_ / "liver.toml") << text;
  type("r");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) {
    return n.world > world && n.phase == SessionStatus::Phase::kReady &&
           n.snapshot.bodies[0].x.size() > vertices;
  }));
}

// H saves the haptic session, and its replay gives the same state.
TEST_F(WindowFilesTest, HapticRecordingReplaysExactly) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const Vec3d position = facing(window_->viewer());
  hand("mousemove " + pixel(position) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return force(n) > 0.01; }));
  hand("mousemove " + pixel(position + Vec3d{0.01, 0, 0.005}));
  draw_for(0.3);
  hand("mouseup 1");
  type("h");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.saved.empty(); }));
  draw_for(0.1);
  EXPECT_NE(window_->viewer().message.find("turgor replay"), std::string::npos) << window_->viewer().message;
  const Result<HapticRecording> run = read_haptic_recording(folder_ / "out" / "liver-haptic-1.h5");
  ASSERT_TRUE(run) << run.error().message;
  const World world = test::replayed_world(*run, 1);
  double largest = 0;
  for (const ForceSample& sample : world.tools[0].samples) largest = std::max(largest, norm(sample.force));
  EXPECT_GT(largest, 0.01) << "N: the recording contains a contact";
  EXPECT_EQ(state_hash(world), run->hash);
}

}  // namespace
}  // namespace turgor

// Files on their way into a window and out of it.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "tests/window/window_test.hpp"
#include "turgor/sim/live/haptic_replay.hpp"
#include "turgor/view/video.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

TEST_F(WindowTest, a_scene_with_a_mistake_keeps_the_window_open_and_is_read_again_with_r) {
  const fs::path file = folder_ / "mended.toml";
  std::ofstream(file) << "[world]\nduration = -1\n";
  open(file);
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return n.phase == SessionNow::Phase::kFailed; }));
  EXPECT_NE(now().error.find("mended.toml:2"), std::string::npos);
  draw_for(0.2);
  fs::copy_file(liver(folder_), file, fs::copy_options::overwrite_existing);
  type("r");
  EXPECT_TRUE(wait_for_world());
}

/// What GLFW calls when files are dropped.
void drop(const fs::path& file) {
  GLFWwindow* window = glfwGetCurrentContext();
  const GLFWdropfun dropped = glfwSetDropCallback(window, nullptr);
  glfwSetDropCallback(window, dropped);
  ASSERT_TRUE(dropped);
  const char* files[] = {file.c_str()};
  dropped(window, 1, files);
}

TEST_F(WindowTest, a_file_that_is_dropped_is_opened_and_looked_at_as_a_whole) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const int before = now().world;
  drop(block(folder_));
  ASSERT_TRUE(draw_until([&](const SessionNow& n) {
    return n.world > before && n.phase == SessionNow::Phase::kReady && !n.snapshot.bodies.empty();
  }));
  draw_for(0.1);
  EXPECT_EQ(now().snapshot.bodies[0].name, "block");
  const Box box = box_of(now().snapshot);
  for (int i = 0; i < 8; i++) {
    const auto seen = seen_at(window_->viewer().camera, corner(box, i), double(kWidth) / kHeight);
    ASSERT_TRUE(seen);
    EXPECT_LE(std::max(std::abs(seen->x), std::abs(seen->y)), 1.01);
  }
}

/// A sheet of two metres that hangs around a place.
fs::path sheet_around(const fs::path& folder, Vec3d place) {
  std::ofstream(folder / "sheet.toml") << fmt::format(R"([world]
duration = 1
[body.sheet]
model = "cloth"
sheet = {{ corner = [{}, {}, {}], side = [2, 0, 0], up = [0, 2, 2], columns = 8, rows = 8 }}
)",
                                                      place.x - 1, place.y - 1, place.z - 1);
  return folder / "sheet.toml";
}

TEST_F(WindowTest, another_file_is_opened_and_looked_at_as_a_whole) {
  for (const bool around : {false, true}) {
    open(liver(folder_));
    ASSERT_TRUE(wait_for_world());
    const Box before = box_of(now().snapshot);
    open_file(window_->viewer(),  // what a drop on the window calls
              around ? sheet_around(folder_, (before.low + before.high) * 0.5) : block(folder_));
    ASSERT_TRUE(draw_until([&](const SessionNow& n) {
      return n.phase == SessionNow::Phase::kReady && !n.snapshot.bodies.empty() &&
             n.snapshot.bodies[0].name != "liver";
    }));
    draw_for(0.1);
    const Box box = box_of(now().snapshot);
    for (int i = 0; i < 8; i++) {
      const auto seen = seen_at(window_->viewer().camera, corner(box, i), double(kWidth) / kHeight);
      ASSERT_TRUE(seen) << "around " << around;
      EXPECT_LE(std::max(std::abs(seen->x), std::abs(seen->y)), 1.01) << "around " << around;
    }
    window_.reset();
  }
}

TEST_F(WindowTest, colors_that_the_next_scene_does_not_know_are_left_behind) {
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
  ASSERT_TRUE(draw_until([](const SessionNow& n) {
    return n.phase == SessionNow::Phase::kReady && n.snapshot.bodies.size() == 1 &&
           n.snapshot.bodies[0].name == "liver";
  }));
  draw_for(0.1);
  EXPECT_EQ(window_->viewer().display.color, SkinColor::kNone);
}

TEST_F(WindowTest, a_window_that_is_closed_ends_its_video_and_leaves_no_single_pictures) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  type("v");
  draw_for(0.5);
  EXPECT_TRUE(fs::exists(folder_ / "out" / ".film-1"));
  window_.reset();
  EXPECT_FALSE(fs::exists(folder_ / "out" / ".film-1"));
  EXPECT_EQ(fs::exists(folder_ / "out" / "liver-1.mp4"), has_ffmpeg());
}

TEST_F(WindowTest, a_file_that_is_no_scene_is_told_when_it_is_dropped_and_the_window_stays) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  std::ofstream(folder_ / "notes.txt") << "no scene";
  drop(folder_ / "notes.txt");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return n.phase == SessionNow::Phase::kFailed; }));
  EXPECT_NE(now().error.find("notes.txt"), std::string::npos) << now().error;
  drop(liver(folder_));
  EXPECT_TRUE(wait_for_world());
}

TEST_F(WindowTest, a_scene_that_changed_on_disk_is_read_again_with_r) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const std::size_t vertices = now().snapshot.bodies[0].x.size();
  const int world = now().world;
  std::ifstream file(folder_ / "liver.toml");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  text.replace(text.find("detail = 0.5"), 12, "detail = 0.8");
  std::ofstream(folder_ / "liver.toml") << text;
  type("r");
  EXPECT_TRUE(draw_until([&](const SessionNow& n) {
    return n.world > world && n.phase == SessionNow::Phase::kReady &&
           n.snapshot.bodies[0].x.size() > vertices;
  }));
}

TEST_F(WindowTest, all_that_was_felt_is_saved_with_h_and_done_again_to_the_same_bits) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const Vec3d place = facing(window_->viewer());
  hand("mousemove " + pixel(place) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return force(n) > 0.01; }));
  hand("mousemove " + pixel(place + Vec3d{0.01, 0, 0.005}));
  draw_for(0.3);
  hand("mouseup 1");
  type("h");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return !n.saved.empty(); }));
  draw_for(0.1);
  EXPECT_NE(window_->viewer().message.find("turgor replay"), std::string::npos) << window_->viewer().message;
  const Result<HapticRecording> run = read_haptic_recording(folder_ / "out" / "liver-felt-1.h5");
  ASSERT_TRUE(run) << run.error().message;
  Result<World> world = load_world(Exec(1), *scene_of(*run));
  ASSERT_TRUE(world) << world.error().message;
  auto replay = HapticReplay::begin(*world, *run);
  ASSERT_TRUE(replay) << replay.error().message;
  for (int frame = 0; frame < run->frames; frame++) {
    ASSERT_TRUE((*replay)->next_frame(Exec(1)));
    ASSERT_TRUE(step(Exec(1), *world));
  }
  (*replay)->end();
  double largest = 0;
  for (const ForceSample& sample : world->tools[0].samples) largest = std::max(largest, norm(sample.force));
  EXPECT_GT(largest, 0.01) << "N: it was felt";
  EXPECT_EQ(state_hash(*world), run->hash);
}

}  // namespace
}  // namespace turgor

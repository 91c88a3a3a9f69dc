// Menus, panels, the status line and drops of a real window, by mouse.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "tests/window/drag_source.hpp"
#include "tests/window/window_test.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

class MenusTest : public WindowTest {
 protected:
  Viewer& viewer() { return window_->viewer(); }
  /// Drops a file as another program does.
  void drop(const fs::path& file) {
    DragSource source;
    ASSERT_TRUE(source.has_target());
    source.drag(file, 600, 300);
    ASSERT_TRUE(draw_until([&](const SessionStatus&) { return source.answer(), source.is_finished; }));
    EXPECT_TRUE(source.is_accepted);
  }
};

// A scene and a line of 3D Slicer that another program drops are opened, and cut.
TEST_F(MenusTest, FilesOfAnotherProgramAreDropped) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const int before = now().world;
  drop(block(folder_));
  ASSERT_TRUE(draw_until([&](const SessionStatus& n) {
    return n.world > before && n.phase == SessionStatus::Phase::kReady && n.snapshot.bodies.size() == 1 &&
           n.snapshot.bodies[0].name == "block";
  })) << viewer().message;
  std::ofstream(folder_ / "cut.mrk.json")
      << R"({"markups": [{"type": "Line", "coordinateSystem": "LPS", "controlPoints": [
    {"position": [10, -20, -30], "positionStatus": "defined"},
    {"position": [10, -20, 30], "positionStatus": "defined"}]}]})";
  drop(folder_ / "cut.mrk.json");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.cuts.size() == 1; })) << viewer().message;
  EXPECT_LT(norm(now().cuts[0].from - Vec3d{0.01, -0.02, -0.03}), 1e-9);
}

// The status is one word: it names loading, pauses, cuts and failures, and only failures are red.
TEST_F(MenusTest, StatusIsOneWord) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  EXPECT_EQ(status_word(viewer()).text, "Running");
  begin_line();
  hand("mouseup 1");
  bool is_cutting = false, has_progress = false;
  ASSERT_TRUE(draw_until([&](const SessionStatus& n) {
    const double done = n.cut_result.done;
    if (n.cut_result.cut >= 0 && done > 0 && done < 1)
      has_progress = true, is_cutting = status_word(viewer()).text == "Cutting";
    return n.cut_result.is_measured;
  }));
  EXPECT_TRUE(has_progress) << "the share of the cut that is done";
  EXPECT_TRUE(is_cutting);
  type("space");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.plays; }));
  EXPECT_EQ(status_word(viewer()).text, "Paused");
  EXPECT_FALSE(status_word(viewer()).is_failure);
  std::ofstream(folder_ / "notes.toml") << "no scene";
  open_file(viewer(), folder_ / "notes.toml");
  leave(viewer());  // without saving the cut
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.phase == SessionStatus::Phase::kFailed; }));
  EXPECT_EQ(status_word(viewer()).text, "Failed");
  EXPECT_TRUE(status_word(viewer()).is_failure);
}

// A changed modulus of a body with inclusions acts at once, Ctrl+Z takes it back, and Ctrl+Y repeats it.
TEST_F(MenusTest, ChangeIsUndoneAndRepeated) {
  open(pad(folder_, kPressingFinger));
  ASSERT_TRUE(wait_for_world());
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.snapshot.time > 0.3; }));
  const double soft = force(now());
  ASSERT_GT(soft, 0.01) << "N";
  viewer().session.request(ChangeRequest{"body.pad.stiffness_scale", "3"});
  const auto is_times = [&](double times) {
    return [&, times](const SessionStatus& n) { return std::abs(force(n) - times * soft) < 0.05 * soft; };
  };
  EXPECT_TRUE(draw_until(is_times(3))) << force(now()) << " of " << soft;
  EXPECT_TRUE(has_unsaved_edits(viewer()));
  type("ctrl+z");
  EXPECT_TRUE(draw_until(is_times(1))) << force(now());
  EXPECT_FALSE(has_unsaved_edits(viewer()));
  type("ctrl+y");
  EXPECT_TRUE(draw_until(is_times(3))) << force(now());
}

// The near half of a body from a CT is cut away by a key, and its section shows bone and fat in grays.
TEST_F(MenusTest, CutAwayShowsGrayValues) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("3");  // from the patient's right: the section shows fat in front of bone
  type("space");
  type("a");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.snapshot.bodies[0].sections.empty(); }));
  draw_for(1);
  type("p");
  const Image image = read_picture(folder_ / "out" / "block-1.png");
  ASSERT_EQ(image.width, kWidth) << viewer().message;
  const auto gray = [&](int low, int high) {
    return find_pixels(image,
                       [&](int x, int y) {
                         const Rgb c = image.at(x, y);
                         const bool is_gray = std::abs(c.r - c.g) < 24 && std::abs(c.g - c.b) < 24;
                         return x > 340 && y > 40 && y < 680 && is_gray && c.r >= low && c.r < high;
                       })
        .count;
  };
  EXPECT_GT(gray(170, 256), 5000) << "pixels of bone";
  type("a");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.snapshot.bodies[0].sections.empty(); }));
}

}  // namespace
}  // namespace turgor

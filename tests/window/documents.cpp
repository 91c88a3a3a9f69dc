// Opening, saving and leaving scenes in the window.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "tests/window/window_test.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

class DocumentsTest : public WindowTest {
 protected:
  Viewer& viewer() { return window_->viewer(); }
  /// Draws a cut of 60 mm on the block, and waits for its wound.
  void cut_block() {
    begin_line();
    hand("mouseup 1");
    ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.cuts.size() == 1; }));
  }
};

// Escape leaves help, line and mode in turn, and never closes the window.
TEST_F(DocumentsTest, EscapeLeavesModesAndNeverQuits) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  begin_line();
  EXPECT_TRUE(viewer().cut);
  type("Escape");
  EXPECT_FALSE(viewer().cut) << "the line is dropped";
  hand("mouseup 1");
  type("question");
  EXPECT_TRUE(viewer().panels.help);
  type("Escape");
  EXPECT_FALSE(viewer().panels.help);
  EXPECT_EQ(viewer().mode, MouseMode::kCut);
  for (int n = 0; n < 3; n++) type("Escape");
  EXPECT_EQ(viewer().mode, MouseMode::kTouch);
  EXPECT_FALSE(viewer().ends);
  EXPECT_TRUE(now().cuts.empty());
  hand("key ctrl+q");
  EXPECT_FALSE(draw_until([](const SessionStatus&) { return false; }, 2))
      << "without edits it closes at once";
}

// Quitting with an unsaved cut asks; Cancel stays, and a saved cut is not asked about.
TEST_F(DocumentsTest, UnsavedCutIsAskedAbout) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  cut_block();
  EXPECT_TRUE(has_unsaved_edits(viewer()));
  hand("key ctrl+q");
  draw_for(0.2);
  ASSERT_EQ(viewer().document.leaving, Leaving::kQuit);
  EXPECT_FALSE(viewer().ends);
  type("Escape");
  EXPECT_EQ(viewer().document.leaving, Leaving::kNothing);
  type("BackSpace");
  EXPECT_EQ(viewer().document.leaving, Leaving::kRestart) << "a restart removes the cut";
  type("Escape");
  type("ctrl+s");
  EXPECT_FALSE(has_unsaved_edits(viewer())) << viewer().message;
  const Result<Scene> saved = read_scene(folder_ / "block.toml");
  ASSERT_TRUE(saved) << saved.error().message;
  EXPECT_EQ(saved->incisions.size(), 1u);
  hand("key ctrl+q");
  EXPECT_FALSE(draw_until([](const SessionStatus&) { return false; }, 2));
}

// The button of the window asks in the same way.
TEST_F(DocumentsTest, WindowButtonAsksToo) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  cut_block();
  glfwSetWindowShouldClose(glfwGetCurrentContext(), GLFW_TRUE);
  draw_for(0.1);
  EXPECT_EQ(viewer().document.leaving, Leaving::kQuit);
  leave(viewer());
  EXPECT_FALSE(window_->draw());
}

// Undo removes the wound, redo opens it again.
TEST_F(DocumentsTest, UndoAndRedoOfCut) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  cut_block();
  const auto walls = [](const SessionStatus& n) {
    return n.snapshot.bodies[0].triangles.size() - n.snapshot.bodies[0].wall_begin;
  };
  ASSERT_TRUE(draw_until([&](const SessionStatus& n) { return walls(n) > 30; }));
  type("ctrl+z");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return walls(n) == 0 && n.cuts.empty(); }));
  EXPECT_FALSE(has_unsaved_edits(viewer()));
  type("ctrl+shift+z");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return walls(n) > 30; }));
}

// Undo in a paused world is drawn: the picture is that from before the cut.
TEST_F(DocumentsTest, UndoIsDrawnWhilePaused) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  int count = 0;
  const auto saved_picture = [&] {
    draw_for(0.8);  // until the full quality
    type("p");
    return read_picture(folder_ / "out" / fmt::format("block-{}.png", ++count));
  };
  type("1");
  type("space");
  const Image before = saved_picture();
  type("space");
  cut_block();
  const auto walls = [](const SessionStatus& n) {
    return n.snapshot.bodies[0].triangles.size() - n.snapshot.bodies[0].wall_begin;
  };
  ASSERT_TRUE(draw_until([&](const SessionStatus& n) { return walls(n) > 30 && n.cut_result.is_measured; }));
  type("space");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.plays; }));
  const Image wounded = saved_picture();
  type("ctrl+z");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.cuts.empty(); }));
  const Image undone = saved_picture();
  for (const Image& image : {before, wounded, undone}) ASSERT_EQ(image.width, kWidth);
  // pixels around the middle of the wound that differ from the picture before
  int x = 0, y = 0;
  ASSERT_EQ(std::sscanf(pixel({0.01, -0.02, 0}).c_str(), "%d %d", &x, &y), 2);
  const auto differing = [&](const Image& image) {
    int found = 0;
    for (int dy = -20; dy <= 20; dy++)
      for (int dx = -20; dx <= 20; dx++) {
        const Rgb a = image.at(x + dx, y + dy), b = before.at(x + dx, y + dy);
        found += std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b) > 30;
      }
    return found;
  };
  EXPECT_GT(differing(wounded), 100);
  EXPECT_LT(differing(undone), 20);
}

// A file that another program changed is not overwritten.
TEST_F(DocumentsTest, ForeignChangeIsNotOverwritten) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  cut_block();
  std::ofstream(folder_ / "block.toml", std::ios::app) << "# a comment\n";
  type("ctrl+s");
  EXPECT_NE(viewer().message.find("changed by another program"), std::string::npos) << viewer().message;
  EXPECT_EQ(viewer().message, viewer().failure);
  EXPECT_EQ(read_scene(folder_ / "block.toml")->incisions.size(), 0u);
}

// A restart after Save reads the saved cuts, so that the next Save keeps them.
TEST_F(DocumentsTest, RestartAfterSaveKeepsCuts) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  cut_block();
  const int world = now().world;
  type("ctrl+s");
  EXPECT_EQ(read_scene(folder_ / "block.toml")->incisions.size(), 1u) << viewer().message;
  type("BackSpace");
  ASSERT_TRUE(draw_until(
      [&](const SessionStatus& n) { return n.world > world && n.phase == SessionStatus::Phase::kReady; }));
  EXPECT_EQ(now().scene->incisions.size(), 1u) << "the cut is of the scene";
  type("ctrl+s");
  EXPECT_EQ(read_scene(folder_ / "block.toml")->incisions.size(), 1u) << viewer().message;
}

// Save as does not overwrite another file.
TEST_F(DocumentsTest, SaveAsKeepsOtherFiles) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  std::ofstream(folder_ / "other.toml") << "# precious\n";
  save_new(viewer(), folder_ / "other.toml");
  EXPECT_NE(viewer().message.find("exists already"), std::string::npos) << viewer().message;
  save_new(viewer(), folder_ / "block.toml");
  EXPECT_EQ(viewer().message.find("not saved"), std::string::npos) << "its own file";
}

// A copy in another folder finds the files of the scene.
TEST_F(DocumentsTest, SavedElsewhereFindsItsFiles) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  cut_block();
  fs::create_directories(folder_ / "other");
  save_as(viewer(), folder_ / "other" / "copy.toml");
  const Result<Scene> saved = read_scene(folder_ / "other" / "copy.toml");
  ASSERT_TRUE(saved) << viewer().message << saved.error().message;
  EXPECT_TRUE(load_world(Exec(1), *saved));
  EXPECT_EQ(viewer().settings.recent.front(), folder_ / "other" / "copy.toml");
  draw_for(0.1);
  EXPECT_EQ(viewer().document.file, folder_ / "other" / "copy.toml") << "Save writes the copy from now on";
}

// The dialog opens a scene whose name is typed.
TEST_F(DocumentsTest, DialogOpensTypedScene) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  liver(folder_);
  const int world = now().world;
  type("ctrl+o");
  draw_for(0.2);
  ASSERT_TRUE(viewer().document.dialog.is_open);
  ASSERT_EQ(viewer().document.dialog.list.entries.size(), 2u) << "the two scenes, not the CT";
  viewer().document.dialog.name = "liver.toml";
  const auto file = confirm(viewer().document.dialog);
  ASSERT_TRUE(file);
  open_file(viewer(), *file);
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) {
    return n.world > world && n.phase == SessionStatus::Phase::kReady && n.snapshot.bodies[0].name == "liver";
  }));
  draw_for(0.2);
  EXPECT_FALSE(viewer().document.dialog.is_open);
}

// Without a scene the gallery is shown; a click on a scene opens it as an example.
TEST_F(DocumentsTest, GalleryOpensExample) {
  liver(folder_);
  setenv("TURGOR_SCENES", folder_.c_str(), 1);
  open("");
  draw_for(0.3);
  EXPECT_EQ(now().phase, SessionStatus::Phase::kEmpty);
  ASSERT_TRUE(viewer().shows_gallery);
  const Area& area = viewer().area;
  hand(fmt::format("mousemove {:.0f} {:.0f}", area.x + 100, area.y + 130));
  draw_for(0.1);
  hand("mousedown 1");
  draw_for(0.1);
  hand("mouseup 1");
  EXPECT_TRUE(wait_for_world());
  unsetenv("TURGOR_SCENES");
  EXPECT_FALSE(viewer().shows_gallery);
  EXPECT_TRUE(viewer().document.is_example);
  type("ctrl+s");
  EXPECT_TRUE(viewer().document.dialog.is_open) << "an example is saved under another name";
}

// A scene that is opened waits, with a hint, until Play is pressed.
TEST_F(DocumentsTest, OpenedSceneWaitsForPlay) {
  WindowOptions options{.scene = liver(folder_), .overrides = {}, .out = folder_ / "out", .session = {}};
  options.width = kWidth, options.height = kHeight, options.session.plays = false;
  open_with(options);
  ASSERT_TRUE(draw_until([](const SessionStatus& n) {
    return n.phase == SessionStatus::Phase::kReady && !n.snapshot.bodies.empty();
  }));
  draw_for(0.4);
  EXPECT_EQ(now().snapshot.frame, 0);
  const Area& area = viewer().area;
  hand(fmt::format("mousemove {:.0f} {:.0f}", area.x + 0.5 * area.width - 270, area.y + area.height - 45));
  draw_for(0.1);
  hand("mousedown 1");
  draw_for(0.1);
  hand("mouseup 1");
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return n.snapshot.frame > 3; }));
}

}  // namespace
}  // namespace turgor

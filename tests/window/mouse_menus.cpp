// Menus, the file dialog and questions of a real window, by mouse.
#include "tests/window/panel_hand.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;
using MouseMenusTest = PanelTest;

constexpr auto kIsReady = [](const SessionStatus& n) {
  return n.phase == SessionStatus::Phase::kReady && !n.snapshot.bodies.empty();
};

// A scene of the list of recent files is opened by two clicks, and the list can be forgotten.
TEST_F(MouseMenusTest, RecentSceneIsOpened) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const fs::path other = block(folder_);
  add_recent(other, viewer().settings);
  ASSERT_TRUE(open_menu("File"));
  ASSERT_TRUE(point_at(popup(), {"Open recent"}));
  draw_for(0.4);  // the list opens below the resting mouse
  ASSERT_TRUE(click_item(popup(), {other.string()}));
  EXPECT_TRUE(
      draw_until([](const SessionStatus& n) { return kIsReady(n) && n.snapshot.bodies[0].name == "block"; }));
  EXPECT_EQ(viewer().settings.recent.front(), other);
  ASSERT_TRUE(open_menu("File"));
  ASSERT_TRUE(point_at(popup(), {"Open recent"}));
  draw_for(0.4);
  ASSERT_TRUE(click_item(popup(), {"Forget all"}));
  EXPECT_TRUE(viewer().settings.recent.empty());
}

// Open… lists the scenes of the folder; a click chooses one, and the button opens it.
TEST_F(MouseMenusTest, DialogOpensClickedScene) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  block(folder_);
  ASSERT_TRUE(choose("File", "Open…"));
  draw_for(0.1);
  ASSERT_TRUE(click_item(panel("/entries_"), {"block.toml"}));
  EXPECT_EQ(viewer().document.dialog.name, "block.toml");
  ASSERT_TRUE(click_item(popup(), {"Open"}));
  EXPECT_TRUE(
      draw_until([](const SessionStatus& n) { return kIsReady(n) && n.snapshot.bodies[0].name == "block"; }));
}

// Save as… writes the typed name, and Quit closes the window.
TEST_F(MouseMenusTest, SaveAsAndQuit) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  ASSERT_TRUE(choose("File", "Save as…"));
  draw_for(0.1);
  ASSERT_TRUE(click_item(popup(), {"##name"}));
  hand("keydown ctrl keydown a");  // selects the name
  draw_twice();
  hand("keyup a keyup ctrl");
  draw_twice();
  hand("type copy");
  draw_for(0.3);
  ASSERT_TRUE(click_item(popup(), {"Save"}));
  EXPECT_TRUE(fs::exists(folder_ / "copy.toml")) << viewer().message << viewer().document.dialog.name;
  ASSERT_TRUE(open_menu("File"));
  ASSERT_TRUE(point_at(popup(), {"Quit"}));
  hand("mousedown 1");
  window_->draw();
  hand("mouseup 1");
  EXPECT_FALSE(draw_until([](const SessionStatus&) { return false; }, 5));
  EXPECT_TRUE(viewer().ends);
}

// The menus Edit and View undo a change, repeat it, and set view, theme and panels.
TEST_F(MouseMenusTest, EditAndViewAct) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  viewer().session.request(ChangeRequest{"body.liver.stiffness_scale", "2"});
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.undo.empty(); }));
  ASSERT_TRUE(choose("Edit", "Undo " + now().undo));
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return n.undo.empty() && !n.redo.empty(); }));
  ASSERT_TRUE(choose("Edit", "Redo " + now().redo));
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return !n.undo.empty() && n.redo.empty(); }));
  // view
  const Camera before = viewer().camera;
  ASSERT_TRUE(choose("View", "Head"));
  EXPECT_GT(norm(viewer().camera.eye - before.eye), 0.01) << "m";
  ASSERT_TRUE(choose("View", "Light theme"));
  ASSERT_TRUE(choose("View", "Larger text"));
  EXPECT_EQ(viewer().settings.appearance, (Appearance{Theme::kLight, 18}));
  ASSERT_TRUE(choose("View", "Side panel"));
  draw_twice();
  EXPECT_EQ(viewer().area.x, 0) << "the panel is hidden";
}

// Record saves a picture, and Help shows the keys.
TEST_F(MouseMenusTest, RecordAndHelpAct) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  ASSERT_TRUE(choose("Record", "Without panels"));
  EXPECT_TRUE(viewer().records_picture_only);
  type("Escape");
  ASSERT_TRUE(choose("Record", "Save a picture"));
  draw_twice();
  const Image image = read_picture(folder_ / "out" / "liver-1.png");
  EXPECT_NEAR(image.width, viewer().area.width, 1) << "without the panel";
  ASSERT_TRUE(choose("Help", "Mouse and keys"));
  EXPECT_TRUE(viewer().panels.help);
  ASSERT_TRUE(choose("File", "Gallery"));
  EXPECT_TRUE(viewer().shows_gallery);
}

// Quitting with a change asks; Cancel stays, and Don't save leaves.
TEST_F(MouseMenusTest, QuestionIsAnswered) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  viewer().session.request(ChangeRequest{"body.liver.stiffness_scale", "2"});
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.undo.empty(); }));
  ASSERT_TRUE(choose("File", "Quit"));
  draw_for(0.1);
  ASSERT_EQ(viewer().document.leaving, Leaving::kQuit);
  ImGuiWindow* question = popup();
  ASSERT_TRUE(question);
  ASSERT_TRUE(click_item(question, {"Cancel"}));
  EXPECT_EQ(viewer().document.leaving, Leaving::kNothing);
  EXPECT_FALSE(viewer().ends);
  ASSERT_TRUE(choose("File", "Quit"));
  draw_for(0.1);
  question = popup();
  ASSERT_TRUE(question);
  ASSERT_TRUE(point_at(question, {"Don't save"}));
  hand("mousedown 1");
  window_->draw();
  hand("mouseup 1");
  EXPECT_FALSE(draw_until([](const SessionStatus&) { return false; }, 5));
}

}  // namespace
}  // namespace turgor

// Size of the window, the side panel and the appearance.
#include "tests/window/window_test.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;
using LayoutTest = WindowTest;

// The window opens at 1280 × 800, with the picture beside the side panel.
TEST_F(LayoutTest, OpensAt1280By800WithSidePanel) {
  open_with({.scene = liver(folder_), .overrides = {}, .out = folder_ / "out", .session = {}});
  ASSERT_TRUE(wait_for_world());
  draw_for(0.2);
  const Image image = window_->picture();
  EXPECT_EQ(image.width, 1280);
  EXPECT_EQ(image.height, 800);
  const Area& area = window_->viewer().area;
  EXPECT_NEAR(area.x, 320, 1) << "the width of the side panel";
  EXPECT_NEAR(area.x + area.width, 1280, 1);
  EXPECT_LT(area.y + area.height, 800) << "the status line is below";
  type("Tab");
  EXPECT_EQ(window_->viewer().area.x, 0) << "the picture takes the place of the hidden panel";
}

// Size, panels, theme and text size are remembered in the next session.
TEST_F(LayoutTest, SizePanelsAndThemeAreRemembered) {
  WindowOptions options{.scene = liver(folder_), .overrides = {}, .out = folder_ / "out", .session = {}};
  options.settings = folder_ / "config" / "window.json";
  open_with(options);
  ASSERT_TRUE(wait_for_world());
  hand("search --name Turgor windowsize 900 640");
  draw_for(0.4);
  type("Tab");
  window_->viewer().settings.appearance = {Theme::kLight, 20};
  draw_for(0.1);
  window_.reset();
  open_with(options);
  ASSERT_TRUE(wait_for_world());
  const Image image = window_->picture();
  EXPECT_EQ(image.width, 900);
  EXPECT_EQ(image.height, 640);
  EXPECT_FALSE(window_->viewer().panels.controls);
  EXPECT_EQ(window_->viewer().settings.appearance, (Appearance{Theme::kLight, 20}));
  EXPECT_EQ(window_->viewer().settings.recent.front(), fs::absolute(liver(folder_)));
}

// Dragging the border of the side panel changes its width.
TEST_F(LayoutTest, SidePanelBorderCanBeDragged) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const Camera before = window_->viewer().camera;
  hand("mousemove 320 600");
  draw_for(0.1);
  hand("mousedown 1");
  draw_for(0.1);
  hand("mousemove 420 600");
  draw_for(0.1);
  hand("mouseup 1");
  draw_for(0.1);
  EXPECT_NEAR(window_->viewer().area.x, 420, 2);
  EXPECT_EQ(window_->viewer().camera.eye, before.eye) << "the drag does not turn the camera";
}

double mean_brightness(const Image& image, int x_end) {
  double sum = 0;
  for (int y = 0; y < image.height; y++)
    for (int x = 0; x < x_end; x++) sum += double(image.at(x, y).r) + image.at(x, y).g + image.at(x, y).b;
  return sum / (3.0 * x_end * image.height);
}

// The light theme brightens the side panel, not the picture.
TEST_F(LayoutTest, LightThemeBrightensSidePanel) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  draw_for(0.2);
  type("p");
  const double dark = mean_brightness(read_picture(folder_ / "out" / "liver-1.png"), 300);
  window_->viewer().settings.appearance.theme = Theme::kLight;
  draw_for(0.2);
  type("p");
  const double light = mean_brightness(read_picture(folder_ / "out" / "liver-2.png"), 300);
  EXPECT_GT(dark, 5);
  EXPECT_LT(dark, 80);
  EXPECT_GT(light, 180);
}

// On a monitor with scale 2 the side panel is twice as wide, and the picture keeps its mouse.
TEST_F(LayoutTest, MonitorScaleDoublesPanels) {
  WindowOptions options{.scene = liver(folder_), .overrides = {}, .out = folder_ / "out", .session = {}};
  options.width = 1280, options.height = 800, options.scale = 2;
  open_with(options);
  ASSERT_TRUE(wait_for_world());
  draw_for(0.2);
  EXPECT_NEAR(window_->viewer().area.x, 640, 1);
  hand("mousemove " + pixel(facing(window_->viewer())) + " mousedown 1");
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return force(n) > 0.01; }));
  hand("mouseup 1");
}

}  // namespace
}  // namespace turgor

#include "turgor/window/window.hpp"

#include "tests/window/window_test.hpp"
#include "turgor/window/ct_pictures.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

// Pressing the liver gives a force, the wheel presses deeper and release ends the force.
TEST_F(WindowTest, PressForceFollowsMouse) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  EXPECT_EQ(force(now()), 0);
  hand("mousemove " + pixel(facing(window_->viewer())) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return force(n) > 0.01; })) << "the curve rises";
  draw_for(0.5);
  const double pressed = force(now());
  hand("click 4 click 4 click 4 click 4");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return force(n) > 1.15 * pressed; })) << pressed;
  hand("mouseup 1");
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return force(n) == 0; }));
}

// Dragging with shift pulls the tissue along.
TEST_F(WindowTest, ShiftDragPullsTissue) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const Vec3d position = facing(window_->viewer());
  const Vec3d right = camera_frame(window_->viewer().camera).right;
  hand("mousemove " + pixel(position) + " keydown shift mousedown 1");
  draw_for(0.7);
  hand("mousemove " + pixel(position + right * 0.015));
  const auto pulled = [&](const SessionStatus& n) {
    double most = 0;
    for (const Vec3 u : n.snapshot.bodies[0].displacement) most = std::max(most, dot(Vec3d(u), right));
    return most;
  };
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return pulled(n) > 0.004; })) << pulled(now()) << " m";
  hand("mouseup 1 keyup shift");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return pulled(n) < 0.001; }));
}

// A line drawn in cut mode opens a wound and is saved with the scene.
TEST_F(WindowTest, DrawnLineCutsAndIsSaved) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("1");  // from the front
  type("c");
  const auto walls = [](const SessionStatus& n) {
    return n.snapshot.bodies[0].triangles.size() - n.snapshot.bodies[0].wall_begin;
  };
  EXPECT_EQ(walls(now()), 0u);
  hand("mousemove " + pixel({0.01, -0.02, -0.03}) + " mousedown 1");
  draw_for(0.1);
  hand("mousemove " + pixel({0.01, -0.02, 0}));
  draw_for(0.1);
  hand("mousemove " + pixel({0.01, -0.02, 0.03}));
  draw_for(0.1);
  hand("mouseup 1");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return walls(n) > 30; }));
  type("s");
  EXPECT_TRUE(draw_until([&](const SessionStatus&) { return fs::exists(folder_ / "block-1.toml"); }));
  const Result<Scene> saved = read_scene(folder_ / "block-1.toml");
  ASSERT_TRUE(saved) << window_->viewer().message << saved.error().message;
  ASSERT_EQ(saved->incisions.size(), 1u);
  const lattice::Incision& blade = saved->incisions[0].blade;
  EXPECT_LT(norm(blade.from - Vec3d{0.01, -0.02, -0.03}), 0.003) << "m: a pixel is half a millimeter";
  EXPECT_LT(norm(blade.to - Vec3d{0.01, -0.02, 0.03}), 0.003);
  type("BackSpace");
  EXPECT_TRUE(draw_until(
      [&](const SessionStatus& n) { return n.phase == SessionStatus::Phase::kReady && walls(n) == 0; }));
}

// A click of another button does not end the line that the left button draws.
TEST_F(WindowTest, OtherButtonKeepsDrawnLine) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  begin_line();
  hand("click 3");
  draw_for(0.3);
  EXPECT_TRUE(window_->viewer().cut);
  EXPECT_TRUE(now().cuts.empty());
  hand("mouseup 1");
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return n.cuts.size() == 1; }));
}

// The CT of a body is shown in sections and as a volume.
TEST_F(WindowTest, DeformedCtIsShown) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("1");
  type("x");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.ct != nullptr; }));
  EXPECT_EQ(n_samples_above(*now().ct, 500), n_samples_above({0, block_ct()}, 500)) << "bone samples";
  window_->viewer().display.volume = true;
  window_->viewer().display.preset = "bone";
  draw_for(2);
  type("p");
  const Image image = read_picture(folder_ / "out" / "block-1.png");
  ASSERT_EQ(image.width, kWidth) << window_->viewer().message;
  const auto bright = find_pixels(image, [&](int x, int y) {
    const Rgb c = image.at(x, y);
    return x > 340 && c.r > 120 && c.g > 100;
  });
  EXPECT_GT(bright.count, 10000) << "pixels of bone behind the fat";
}

// Space pauses, the period key steps and minus slows the simulation.
TEST_F(WindowTest, KeysPauseStepAndSlow) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  type("space");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return !n.plays; }));
  const int frame = now().snapshot.frame;
  draw_for(0.3);
  EXPECT_EQ(now().snapshot.frame, frame);
  type("period");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return n.snapshot.frame == frame + 1; }));
  type("minus");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return n.plays && n.pace == 0.5; }));
  hand("keydown space");
  draw_for(1.5);
  hand("keyup space");
  draw_for(0.1);
  EXPECT_FALSE(now().plays) << "once, however long it is held";
}

// Beside the body the mouse orbits the camera and the wheel zooms.
TEST_F(WindowTest, MouseBesideBodyMovesCamera) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const Camera before = window_->viewer().camera;
  hand("mousemove 700 30 mousedown 1 mousemove 760 30");
  draw_for(0.2);
  hand("mouseup 1");
  draw_for(0.1);
  const Camera turned = window_->viewer().camera;
  EXPECT_GT(norm(turned.eye - before.eye), 0.01);
  EXPECT_EQ(turned.target, before.target);
  EXPECT_EQ(force(now()), 0) << "no contact";
  hand("click 4");
  draw_for(0.2);
  const Camera nearer = window_->viewer().camera;
  EXPECT_NEAR(norm(nearer.eye - nearer.target), 0.9 * norm(turned.eye - turned.target), 1e-9);
}

// Saved pictures show the body, and the help covers it.
TEST_F(WindowTest, SavedPicturesShowBodyAndHelp) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  draw_for(0.3);
  const auto flesh = [](const Image& image) {
    return find_pixels(image, [&](int x, int y) {
      const Rgb c = image.at(x, y);
      return c.r > 60 && c.r > 2 * c.g && c.r > 2 * c.b;
    });
  };
  type("p");
  const Image saved = read_picture(folder_ / "out" / "liver-1.png");
  ASSERT_EQ(saved.width, kWidth) << window_->viewer().message;
  const auto found = flesh(saved);
  EXPECT_GT(found.count, 20000) << "pixels of liver";
  const Area& area = window_->viewer().area;
  EXPECT_NEAR(found.x, area.x + area.width / 2, 120);
  type("question");
  draw_for(0.2);
  EXPECT_TRUE(window_->viewer().panels.help);
  type("p");
  const Image help = read_picture(folder_ / "out" / "liver-2.png");
  ASSERT_EQ(help.width, kWidth);
  EXPECT_LT(flesh(help).count, 0.8 * found.count) << "the help covers it";
}

// A window that stalls for a second does not slow the haptic loop.
TEST_F(WindowTest, StalledWindowKeepsHapticRate) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  hand("mousemove " + pixel(facing(window_->viewer())) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return force(n) > 0.01; }));
  draw_for(0.3);
  const haptics::TimingReport before = now().haptics;
  const double begin = now().snapshot.time;
  std::this_thread::sleep_for(std::chrono::seconds(1));
  draw_for(0.3);
  const haptics::TimingReport after = now().haptics;
  EXPECT_GT(now().snapshot.time, begin + 0.7) << "s: the simulation continued";
  EXPECT_GT(after.ticks + after.missed, before.ticks + before.missed + 900) << "the loop kept its rate";
  EXPECT_LT(after.period.largest, 0.5) << "s: no pause of the stall's length";
  hand("mouseup 1");
}

/// Number of pixels with the color of the patch's edges.
int patch_pixels(const Image& image) {
  return int(find_pixels(image, [&](int x, int y) {
               const Rgb c = image.at(x, y);
               return c.g > 120 && c.b > 110 && c.r < 0.6 * c.g;
             }).count);
}

// The U key shows the local patch of elements at the tool.
TEST_F(WindowTest, PatchIsShownAtTool) {
  std::ofstream(folder_ / "pad.toml") << R"([world]
duration = 1
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [8, 8, 4] }
fixed = "bottom"
cache = false
patch = { radius = 0.012 }
[tool.finger]
body = "pad"
shape = { sphere = 0.004 }
path = [[0, 0.015, 0.015, 0.04]]
)";
  open(folder_ / "pad.toml");
  ASSERT_TRUE(wait_for_world());
  type("5");  // from the head
  draw_for(0.3);
  type("p");
  type("n");
  EXPECT_TRUE(window_->viewer().display.organ_forces);
  type("u");
  draw_for(0.2);
  type("p");
  const Image without = read_picture(folder_ / "out" / "pad-1.png"),
              with = read_picture(folder_ / "out" / "pad-2.png");
  ASSERT_EQ(with.width, kWidth) << window_->viewer().message;
  EXPECT_GT(patch_pixels(with), patch_pixels(without) + 300);
  const TriMesh& patch = now().snapshot.bodies[0].patch;
  ASSERT_FALSE(patch.triangles.empty());
  for (const Vec3 x : patch.vertices)
    EXPECT_LT(std::hypot(x.x - 0.015, x.y - 0.015), 0.035) << "m: the elements near the tool, and no others";
}

// A volume is drawn coarsely while the camera moves and finely at rest.
TEST_F(WindowTest, VolumeRefinesWhenCameraRests) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  auto ct = std::make_shared<const DeformedCt>(DeformedCt{0, block_ct()});
  VolumePicture picture;
  VolumeRequest request{ct, "bone", window_->viewer().camera, 320, 240};
  const auto until = [&](int width) {
    for (const Timer timer; timer.seconds() < 20; std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
      EXPECT_TRUE(renew(request, picture));
      if (picture.image.width == width) return true;
    }
    return false;
  };
  EXPECT_TRUE(until(80)) << "at first one ray for 4 x 4 pixels";
  EXPECT_TRUE(until(160)) << "then finer";
  EXPECT_TRUE(until(320)) << "and as fine as the window";
  for (int n = 0; n < 20; n++) {  // a camera that moves faster than rays are cast
    request.camera = orbited(request.camera, 0.05, 0);
    EXPECT_TRUE(renew(request, picture));
    EXPECT_TRUE(picture.image.width == 320 || picture.image.width == 80) << picture.image.width;
    if (picture.coming.valid()) picture.coming.wait();
  }
  EXPECT_EQ(picture.image.width, 80) << "while it moves";
  EXPECT_TRUE(until(320)) << "at rest again";
}

// The window can be resized during a press, and Ctrl+Q closes it.
TEST_F(WindowTest, ResizesWhilePressedQuitCloses) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  hand("mousemove " + pixel(facing(window_->viewer())) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return force(n) > 0.01; }));
  hand("search --name Turgor windowsize 700 500");
  draw_for(0.5);
  EXPECT_GT(force(now()), 0.01) << "still pressed";
  const Area& area = window_->viewer().area;
  EXPECT_NEAR(area.x + area.width, 700, 1e-9);
  EXPECT_NEAR(window_->viewer().aspect, area.aspect(), 1e-9);
  type("p");
  EXPECT_EQ(read_picture(folder_ / "out" / "liver-1.png").width, 700);
  hand("mouseup 1 key ctrl+q");
  EXPECT_FALSE(draw_until([](const SessionStatus&) { return false; }, 5))
      << "draw() reports that the window is closed";
  EXPECT_TRUE(window_->viewer().ends);
}

// Without a display the error names the command that needs none.
TEST(NoWindow, MissingDisplayIsExplained) {
  const char* had = std::getenv("DISPLAY");
  const std::string display = had ? had : "";
  unsetenv("DISPLAY"), unsetenv("WAYLAND_DISPLAY");
  const auto opened = SceneWindow::open({.scene = "scenes/palpation.toml", .overrides = {}, .session = {}});
  if (!display.empty()) setenv("DISPLAY", display.c_str(), 1);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("turgor run scenes/palpation.toml"), std::string::npos)
      << opened.error().message;
}

}  // namespace
}  // namespace turgor

// A real window on a display without a screen, driven by synthetic mouse and keyboard.
#include "turgor/window/window.hpp"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <png.h>

#include "sim/four_kinds.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/view/video.hpp"
#include "view/shapes.hpp"
#include "window/screen.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 960, kHeight = 720;

test::Screen& screen() {
  static test::Screen the_screen;
  return the_screen;
}

class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!screen().missing.empty()) GTEST_SKIP() << screen().missing;
  }

  void open(const fs::path& scene, const std::vector<std::string>& overrides = {}) {
    WindowOptions options{.scene = scene, .overrides = overrides, .out = folder_ / "out"};
    options.session = {.threads = 1, .loop = {.priority = 0, .lock_memory = false}, .longest = 60};
    Result<std::unique_ptr<SceneWindow>> opened = SceneWindow::open(options);
    ASSERT_TRUE(opened) << opened.error().message;
    window_ = std::move(*opened);
  }

  const SessionNow& now() { return *window_->viewer().now; }
  bool draw_until(const std::function<bool(const SessionNow&)>& is_so, double longest = 20) {
    const Timer timer;
    while (window_ && timer.seconds() < longest)
      if (!window_->draw())
        return false;
      else if (is_so(now()))
        return true;
    return false;
  }
  bool wait_for_world() {
    return draw_until(
        [](const SessionNow& n) { return n.phase == SessionNow::Phase::kReady && n.shown.frame > 2; });
  }
  void draw_for(double seconds) {
    const Timer timer;
    while (timer.seconds() < seconds) ASSERT_TRUE(window_->draw());
  }

  /// A place of the world as xdotool names it.
  std::string pixel(Vec3d point) {
    const auto seen = seen_at(window_->viewer().camera, point, double(kWidth) / kHeight);
    return fmt::format("{:.0f} {:.0f}", 0.5 * (1 + seen->x) * kWidth, 0.5 * (1 - seen->y) * kHeight);
  }
  void type(const std::string& keys) { test::hand("key " + keys), draw_for(0.1); }

  fs::path folder_ = test::fresh_folder();
  std::unique_ptr<SceneWindow> window_;
};

/// A phantom liver that the mouse touches, and nothing else.
fs::path liver(const fs::path& folder) {
  const fs::path file = folder / "liver.toml";
  std::ofstream(file) << R"([world]
duration = 1        # s
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 0.5 }
bulge = 0.4
[tool.tip]
body = "liver"
shape = { sphere = 0.008 }
press = { at_fraction = [0.5, 0, 0.5], depth = 0.001, start = 1000 }
)";
  return file;
}

fs::path block(const fs::path& folder) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const std::string text = test::block_scene_text("block.nii");
  std::ofstream(folder / "block.toml") << text.substr(0, text.find("[incision.cut]"));
  return folder / "block.toml";
}

/// No pixels: it is no picture.
Image read_picture(const fs::path& file) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&png, file.c_str())) return {};
  png.format = PNG_FORMAT_RGB;
  Image image = make_image(int(png.width), int(png.height));
  png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr);
  return image;
}

int n_samples_above(const DeformedCt& ct, int hu) {
  return int(
      std::count_if(ct.ct.samples.begin(), ct.ct.samples.end(), [hu](int sample) { return sample > hu; }));
}

double force(const SessionNow& now) { return now.felt[0].empty() ? 0 : now.felt[0].back().force; }

/// The place of a body that lies nearest to the eye's line to its middle.
Vec3d facing(const Viewer& viewer) {
  const Box box = box_of(viewer.now->shown);
  const auto found = pick(viewer.now->shown,
                          {viewer.camera.eye, normalized((box.low + box.high) * 0.5 - viewer.camera.eye)});
  EXPECT_TRUE(found);
  return found ? found->point : box.low;
}

TEST_F(WindowTest, a_press_on_the_liver_is_felt_deeper_with_the_wheel_and_not_any_more_when_it_ends) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  EXPECT_EQ(force(now()), 0);
  test::hand("mousemove " + pixel(facing(window_->viewer())) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return force(n) > 0.01; })) << "the curve rises";
  draw_for(0.5);
  const double pressed = force(now());
  test::hand("click 4 click 4 click 4 click 4");
  EXPECT_TRUE(draw_until([&](const SessionNow& n) { return force(n) > 1.15 * pressed; })) << pressed;
  test::hand("mouseup 1");
  EXPECT_TRUE(draw_until([](const SessionNow& n) { return force(n) == 0; }));
}

TEST_F(WindowTest, what_is_grabbed_with_shift_is_pulled_along) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const Vec3d place = facing(window_->viewer());
  const Vec3d right = camera_frame(window_->viewer().camera).right;
  test::hand("mousemove " + pixel(place) + " keydown shift mousedown 1");
  draw_for(0.7);
  test::hand("mousemove " + pixel(place + right * 0.015));
  const auto pulled = [&](const SessionNow& n) {
    double most = 0;
    for (const Vec3 u : n.shown.bodies[0].displacement) most = std::max(most, dot(Vec3d(u), right));
    return most;
  };
  EXPECT_TRUE(draw_until([&](const SessionNow& n) { return pulled(n) > 0.004; })) << pulled(now()) << " m";
  test::hand("mouseup 1 keyup shift");
  EXPECT_TRUE(draw_until([&](const SessionNow& n) { return pulled(n) < 0.001; }));
}

TEST_F(WindowTest, a_line_drawn_on_skin_in_cut_mode_opens_a_wound_and_is_saved_with_the_scene) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("1");  // from the front
  type("c");
  const auto walls = [](const SessionNow& n) {
    return n.shown.bodies[0].triangles.size() - n.shown.bodies[0].wall_begin;
  };
  EXPECT_EQ(walls(now()), 0u);
  test::hand("mousemove " + pixel({0.01, -0.02, -0.03}) + " mousedown 1");
  draw_for(0.1);
  test::hand("mousemove " + pixel({0.01, -0.02, 0}));
  draw_for(0.1);
  test::hand("mousemove " + pixel({0.01, -0.02, 0.03}));
  draw_for(0.1);
  test::hand("mouseup 1");
  EXPECT_TRUE(draw_until([&](const SessionNow& n) { return walls(n) > 30; }));
  type("s");
  const Result<Scene> saved = read_scene(folder_ / "block-1.toml");
  ASSERT_TRUE(saved) << window_->viewer().message << saved.error().message;
  ASSERT_EQ(saved->incisions.size(), 1u);
  const lattice::Incision& blade = saved->incisions[0].blade;
  EXPECT_LT(norm(blade.from - Vec3d{0.01, -0.02, -0.03}), 0.003) << "m: a pixel is half a millimetre";
  EXPECT_LT(norm(blade.to - Vec3d{0.01, -0.02, 0.03}), 0.003);
  type("BackSpace");
  EXPECT_TRUE(
      draw_until([&](const SessionNow& n) { return n.phase == SessionNow::Phase::kReady && walls(n) == 0; }));
}

TEST_F(WindowTest, the_ct_of_a_body_that_was_cut_is_seen_in_sections_and_as_a_volume) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("1");
  type("x");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return n.ct != nullptr; }));
  EXPECT_EQ(n_samples_above(*now().ct, 500), n_samples_above({0, test::block_ct()}, 500)) << "its bone";
  window_->viewer().display.volume = true;
  window_->viewer().display.preset = "bone";
  draw_for(2);
  type("p");
  const Image image = read_picture(folder_ / "out" / "block-1.png");
  ASSERT_EQ(image.width, kWidth) << window_->viewer().message;
  const auto bright = test::find_pixels(image, [&](int x, int y) {
    const Rgb c = image.at(x, y);
    return x > 340 && x < 680 && c.r > 120 && c.g > 100;
  });
  EXPECT_GT(bright.count, 10000) << "pixels of bone behind the fat";
}

TEST_F(WindowTest, space_pauses_dots_step_and_minus_slows) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  type("space");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return !n.plays; }));
  const int frame = now().shown.frame;
  draw_for(0.3);
  EXPECT_EQ(now().shown.frame, frame);
  type("period");
  EXPECT_TRUE(draw_until([&](const SessionNow& n) { return n.shown.frame == frame + 1; }));
  type("minus");
  EXPECT_TRUE(draw_until([&](const SessionNow& n) { return n.plays && n.pace == 0.5; }));
  test::hand("keydown space");
  draw_for(1.5);
  test::hand("keyup space");
  draw_for(0.1);
  EXPECT_FALSE(now().plays) << "once, however long it is held";
}

TEST_F(WindowTest, beside_the_body_the_mouse_moves_the_camera_and_the_wheel_comes_nearer) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  const Camera before = window_->viewer().camera;
  test::hand("mousemove 500 30 mousedown 1 mousemove 560 30");
  draw_for(0.2);
  test::hand("mouseup 1");
  draw_for(0.1);
  const Camera turned = window_->viewer().camera;
  EXPECT_GT(norm(turned.eye - before.eye), 0.01);
  EXPECT_EQ(turned.target, before.target);
  EXPECT_EQ(force(now()), 0) << "nothing was touched";
  test::hand("click 4");
  draw_for(0.2);
  const Camera nearer = window_->viewer().camera;
  EXPECT_NEAR(norm(nearer.eye - nearer.target), 0.9 * norm(turned.eye - turned.target), 1e-9);
}

TEST_F(WindowTest, its_pictures_show_the_body_and_the_help) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  draw_for(0.3);
  const auto flesh = [](const Image& image) {
    return test::find_pixels(image, [&](int x, int y) {
      const Rgb c = image.at(x, y);
      return c.r > 60 && c.r > 2 * c.g && c.r > 2 * c.b;
    });
  };
  type("p");
  const Image saved = read_picture(folder_ / "out" / "liver-1.png");
  ASSERT_EQ(saved.width, kWidth) << window_->viewer().message;
  const auto found = flesh(saved);
  EXPECT_GT(found.count, 20000) << "pixels of liver";
  EXPECT_NEAR(found.x, kWidth / 2.0, 120);
  type("question");
  draw_for(0.2);
  EXPECT_TRUE(window_->viewer().panels.help);
  type("p");
  const Image help = read_picture(folder_ / "out" / "liver-2.png");
  ASSERT_EQ(help.width, kWidth);
  EXPECT_LT(flesh(help).count, 0.8 * found.count) << "the help lies over it";
}

TEST_F(WindowTest, a_window_that_stalls_for_a_second_costs_the_haptic_loop_nothing) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  test::hand("mousemove " + pixel(facing(window_->viewer())) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return force(n) > 0.01; }));
  draw_for(0.3);
  const haptics::TimingReport before = now().haptics;
  const double begin = now().shown.time;
  std::this_thread::sleep_for(std::chrono::seconds(1));
  draw_for(0.3);
  const haptics::TimingReport after = now().haptics;
  EXPECT_GT(now().shown.time, begin + 0.7) << "s: frames went on";
  EXPECT_GT(after.ticks + after.missed, before.ticks + before.missed + 900) << "the loop kept its time";
  EXPECT_LT(after.period.largest, 0.5) << "s: no pause of the stall's length";
  test::hand("mouseup 1");
}

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
    const Box before = box_of(now().shown);
    open_file(window_->viewer(),  // what a drop on the window calls
              around ? sheet_around(folder_, (before.low + before.high) * 0.5) : block(folder_));
    ASSERT_TRUE(draw_until([&](const SessionNow& n) {
      return n.phase == SessionNow::Phase::kReady && !n.shown.bodies.empty() &&
             n.shown.bodies[0].name != "liver";
    }));
    draw_for(0.1);
    const Box box = box_of(now().shown);
    for (int i = 0; i < 8; i++) {
      const auto seen = seen_at(window_->viewer().camera, corner(box, i), double(kWidth) / kHeight);
      ASSERT_TRUE(seen) << "around " << around;
      EXPECT_LE(std::max(std::abs(seen->x), std::abs(seen->y)), 1.01) << "around " << around;
    }
    window_.reset();
  }
}

TEST_F(WindowTest, colours_that_the_next_scene_does_not_know_are_left_behind) {
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
    return n.phase == SessionNow::Phase::kReady && n.shown.bodies.size() == 1 &&
           n.shown.bodies[0].name == "liver";
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

TEST_F(WindowTest, it_may_be_resized_while_a_body_is_pressed_and_escape_closes_it) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  test::hand("mousemove " + pixel(facing(window_->viewer())) + " mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionNow& n) { return force(n) > 0.01; }));
  test::hand("search --name Turgor windowsize 700 500");
  draw_for(0.5);
  EXPECT_GT(force(now()), 0.01) << "still pressed";
  EXPECT_NEAR(window_->viewer().aspect, 1.4, 1e-9);
  type("p");
  EXPECT_EQ(read_picture(folder_ / "out" / "liver-1.png").width, 700);
  test::hand("mouseup 1 key Escape");
  EXPECT_FALSE(draw_until([](const SessionNow&) { return false; }, 5)) << "draw() says that it was closed";
  EXPECT_TRUE(window_->viewer().ends);
}

TEST(NoWindow, without_a_display_a_sentence_names_what_needs_none) {
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

// Fixture for tests of a real window on a virtual display with synthetic mouse and keyboard.
#pragma once

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <png.h>

#include "tests/sim/four_kinds.hpp"
#include "tests/view/shapes.hpp"
#include "tests/window/screen.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/window/window.hpp"

namespace turgor::test {

namespace fs = std::filesystem;

constexpr int kWidth = 960, kHeight = 720;

inline Screen& screen() {
  static Screen the_screen;
  return the_screen;
}

class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!screen().missing.empty()) GTEST_SKIP() << screen().missing;
  }

  void open(const fs::path& scene, const std::vector<std::string>& overrides = {}) {
    WindowOptions options{.scene = scene, .overrides = overrides, .out = folder_ / "out"};
    options.width = kWidth, options.height = kHeight;
    open_with(options);
  }

  void open_with(WindowOptions options) {
    const bool plays = options.session.plays;
    options.session = {.threads = 1, .loop = {.priority = 0, .lock_memory = false}, .longest = 60};
    options.session.plays = plays;
    Result<std::unique_ptr<SceneWindow>> opened = SceneWindow::open(options);
    ASSERT_TRUE(opened) << opened.error().message;
    window_ = std::move(*opened);
  }

  const SessionStatus& now() { return *window_->viewer().now; }
  bool draw_until(const std::function<bool(const SessionStatus&)>& is_so, double longest = 120) {
    const Timer timer;
    while (window_ && timer.seconds() < longest)
      if (!window_->draw())
        return false;
      else if (is_so(now()))
        return true;
    return false;
  }
  bool wait_for_world() {
    return draw_until([](const SessionStatus& n) {
      return n.phase == SessionStatus::Phase::kReady && n.snapshot.frame > 2;
    });
  }
  /// Draws for some time, and often enough for events on a slow machine: ImGui takes one of a key per
  /// picture.
  void draw_for(double seconds) {
    constexpr int kFewest = 6;
    const Timer timer;
    for (int drawn = 0; drawn < kFewest || timer.seconds() < seconds; drawn++) ASSERT_TRUE(window_->draw());
  }

  /// Screen position of a point, as arguments of xdotool.
  std::string pixel(Vec3d point) {
    const Area& area = window_->viewer().area;
    const auto seen = project(window_->viewer().camera, point, area.aspect());
    return fmt::format("{:.0f} {:.0f}", area.x + 0.5 * (1 + seen->x) * area.width,
                       area.y + 0.5 * (1 - seen->y) * area.height);
  }
  void type(const std::string& keys) { hand("key " + keys), draw_for(0.1); }
  /// Draws the line of a cut on the front of `block`. The left button stays down.
  void begin_line() {
    type("1"), type("c");
    hand("mousemove " + pixel({0.01, -0.02, -0.03}) + " mousedown 1");
    draw_for(0.1);
    hand("mousemove " + pixel({0.01, -0.02, 0.03}));
    draw_for(0.1);
  }

  fs::path folder_ = fresh_folder();
  std::unique_ptr<SceneWindow> window_;
};

/// A scene with a phantom liver that the mouse touches.
inline fs::path liver(const fs::path& folder) {
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

inline fs::path block(const fs::path& folder) {
  EXPECT_TRUE(write_ct(folder / "block.nii", block_ct()));
  const std::string text = block_scene_text("block.nii");
  std::ofstream(folder / "block.toml") << text.substr(0, text.find("[incision.cut]"));
  return folder / "block.toml";
}

/// A soft pad with a hard nodule below its top, and a tool of this scene text.
inline fs::path pad(const fs::path& folder, const std::string& tool) {
  const fs::path file = folder / "pad.toml";
  std::ofstream(file) << R"([world]
duration = 1
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.04], count = [6, 6, 4] }
fixed = "bottom"
young = 4e3
cache = false
[body.pad.inclusion.nodule]
center = [0.03, 0.03, 0.015]
radius = 0.011
young = 12e3
)" << tool;
  return file;
}

/// A fingertip that presses the pad and stays.
constexpr const char* kPressingFinger = R"([tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.03, 0.03, 0.05], [0.1, 0.03, 0.03, 0.042], [1000, 0.03, 0.03, 0.042]]
)";

/// Image of a PNG file. Empty if the file is no PNG.
inline Image read_picture(const fs::path& file) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&png, file.c_str())) return {};
  png.format = PNG_FORMAT_RGB;
  Image image = make_image(int(png.width), int(png.height));
  png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr);
  return image;
}

inline int n_samples_above(const DeformedCt& ct, int hu) {
  return int(
      std::count_if(ct.ct.samples.begin(), ct.ct.samples.end(), [hu](int sample) { return sample > hu; }));
}

inline double force(const SessionStatus& now) {
  return now.haptic[0].empty() ? 0 : now.haptic[0].back().force;
}

/// Position on a body under the sight line from the eye to the center of its box.
inline Vec3d facing(const Viewer& viewer) {
  const Box box = box_of(viewer.now->snapshot);
  const auto found = pick(viewer.now->snapshot,
                          {viewer.camera.eye, normalized((box.low + box.high) * 0.5 - viewer.camera.eye)});
  EXPECT_TRUE(found);
  return found ? found->point : box.low;
}

}  // namespace turgor::test

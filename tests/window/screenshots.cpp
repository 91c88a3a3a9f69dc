// Screenshots of panels, menu, help and gallery, compared with tests/window/references. Blocks of pixels are
// compared, which glyphs of another font rasterizer hardly change. TURGOR_NEW_REFERENCES=1 writes them again.
#include <map>

#include "tests/window/panel_hand.hpp"
#include "turgor/view/text.hpp"
#include "turgor/window/appearance.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

/// Mean colors of square blocks.
Image reduced(const Image& image, int block) {
  Image small = make_image(image.width / block, image.height / block);
  for (int y = 0; y < small.height; y++)
    for (int x = 0; x < small.width; x++) {
      int r = 0, g = 0, b = 0;
      for (int n = 0; n < block * block; n++) {
        const Rgb p = image.at(x * block + n % block, y * block + n / block);
        r += p.r, g += p.g, b += p.b;
      }
      const int count = block * block;
      small.at(x, y) = {std::uint8_t(r / count), std::uint8_t(g / count), std::uint8_t(b / count)};
    }
  return small;
}

/// Largest mean difference of luminance over tiles of 5 x 5 blocks, which are 4 pixels of a reference wide.
double largest_difference(const Image& a, const Image& b) {
  constexpr int kTile = 5;
  const Image one = reduced(a, 4), other = reduced(b, 4);
  const auto luminance = [](Rgb p) { return 0.299 * p.r + 0.587 * p.g + 0.114 * p.b; };
  std::map<std::pair<int, int>, double> tiles;
  for (int y = 0; y < one.height; y++)
    for (int x = 0; x < one.width; x++)
      tiles[{x / kTile, y / kTile}] +=
          std::abs(luminance(one.at(x, y)) - luminance(other.at(x, y))) / (kTile * kTile);
  double largest = 0;
  for (const auto& [at, difference] : tiles) largest = std::max(largest, difference);
  return largest;
}

/// The image with a rectangle in one color.
Image painted(Image image, int left, int top, int right, int bottom, Rgb color) {
  for (int y = std::max(top, 0); y < std::min(bottom, image.height); y++)
    for (int x = std::max(left, 0); x < std::min(right, image.width); x++) image.at(x, y) = color;
  return image;
}

/// The image one pixel to the right and below, as glyphs of another rasterizer may be.
Image shifted(const Image& image) {
  Image moved = image;
  for (int y = 1; y < image.height; y++)
    for (int x = 1; x < image.width; x++) moved.at(x, y) = image.at(x - 1, y - 1);
  return moved;
}

class ScreenshotsTest : public PanelTest {
 protected:
  static constexpr double kTolerance = 8;  // of 255; a missing panel differs by 17 or more

  void open_at_full_size(const fs::path& scene) {
    if (font_file().empty()) GTEST_SKIP() << "DejaVuSans.ttf is not installed (fonts-dejavu-core)";
    WindowOptions options{.scene = scene, .overrides = {}, .out = folder_ / "out", .session = {}};
    options.width = 1280, options.height = 800, options.scale = 1;
    options.session.plays = false;
    open_with(options);
  }

  /// The window as drawn.
  Image screenshot() {
    viewer().wants_picture = true;
    EXPECT_TRUE(window_->draw());
    fs::path latest;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_ / "out"))
      if (latest.empty() || entry.last_write_time() >= fs::last_write_time(latest)) latest = entry.path();
    Image image = read_picture(latest);
    fs::remove(latest);
    return image;
  }

  /// Panels of the window on black, since drawings of bodies differ between drivers.
  static Image shown(const Image& all, const std::vector<std::string>& names) {
    Image image = make_image(all.width, all.height);
    for (const std::string& name : names) {
      ImGuiWindow* window = panel(name);
      if (window == nullptr) continue;
      const ImRect at = window->Rect();
      for (int y = std::max(0, int(at.Min.y)); y < std::min(all.height, int(at.Max.y)); y++)
        for (int x = std::max(0, int(at.Min.x)); x < std::min(all.width, int(at.Max.x)); x++)
          image.at(x, y) = all.at(x, y);
    }
    return image;
  }

  /// Compares panels with a reference. Any of them left out must fail, and a shift by a pixel must not.
  void compare(const std::string& reference, const std::vector<std::string>& names) {
    const fs::path file = fs::path(TURGOR_SOURCE_DIR) / "tests/window/references" / (reference + ".png");
    const Image all = screenshot(), image = shown(all, names), small = reduced(image, 4);
    if (std::getenv("TURGOR_NEW_REFERENCES")) {
      EXPECT_TRUE(write_png(file, small)) << file;
    }
    const Image expected = read_picture(file);
    ASSERT_EQ(expected.width, small.width) << file;
    ASSERT_EQ(expected.height, small.height) << file;
    const double difference = largest_difference(small, expected),
                 moved = largest_difference(reduced(shifted(image), 4), expected);
    std::printf("%s: difference %.2f, shifted by a pixel %.2f\n", reference.c_str(), difference, moved);
    if (!(difference < kTolerance)) {
      const fs::path now = folder_ / (reference + ".png");
      EXPECT_TRUE(write_png(now, image));
      ADD_FAILURE() << "differs from " << file << " by " << difference << ": " << now
                    << "; if the change is wanted, TURGOR_NEW_REFERENCES=1 renews the reference";
    }
    EXPECT_LT(moved, kTolerance) << "the reference is too sensitive for other font rasterizers";
    for (std::size_t n = 0; n < names.size(); n++) {
      std::vector<std::string> others = names;
      others.erase(others.begin() + std::ptrdiff_t(n));
      const double without = largest_difference(reduced(shown(all, others), 4), expected);
      std::printf("  without %s: %.2f\n", names[n].c_str(), without);
      EXPECT_GT(without, kTolerance) << names[n];
    }
  }
};

bool is_paused(const SessionStatus& now) {
  return now.phase == SessionStatus::Phase::kReady && !now.snapshot.bodies.empty();
}

// Side panel, menu bar, status line, camera cube and the hint of a scene that waits for Play.
TEST_F(ScreenshotsTest, PanelsOfPausedScene) {
  open_at_full_size(liver(folder_));
  if (IsSkipped()) return;
  ASSERT_TRUE(draw_until(is_paused));
  hand("mousemove 700 300");
  draw_for(0.3);
  compare("panels", {"side panel", "##MainMenuBar", "status", "start"});
}

// An open menu with its items and their keys.
TEST_F(ScreenshotsTest, MenuOfViews) {
  open_at_full_size(liver(folder_));
  if (IsSkipped()) return;
  ASSERT_TRUE(draw_until(is_paused));
  ASSERT_TRUE(open_menu("View"));
  hand("mousemove 900 600");
  draw_for(0.1);
  ASSERT_TRUE(popup());
  compare("menu", {"##MainMenuBar", popup()->Name});
}

// The help has every group of keys, with all of its keys.
TEST_F(ScreenshotsTest, HelpHasItsGroups) {
  open_at_full_size(liver(folder_));
  if (IsSkipped()) return;
  ASSERT_TRUE(draw_until(is_paused));
  type("question");
  hand("mousemove 10 790");
  draw_for(0.1);
  ImGuiWindow* help = panel("Mouse and keys");
  ASSERT_TRUE(help);
  std::map<std::string, int> rows{{"Mouse on the picture", int(mouse_table().size())}};
  std::string last;
  for (const KeyHelp& key : key_table()) {
    EXPECT_TRUE(last == key.group || rows.count(key.group) == 0)
        << key.name << ": a second group " << key.group;
    rows[last = key.group]++;
  }
  EXPECT_GE(rows.size(), 6u);
  for (const auto& [group, count] : rows) {
    const ImGuiTable* table =
        ImGui::TableFindByID(ImHashStr(group.c_str(), 0, ImHashStr("groups", 0, help->ID)));
    ASSERT_TRUE(table) << group;
    EXPECT_EQ(table->CurrentRow + 1, count) << group;
  }
  compare("help", {"Mouse and keys"});
}

// The gallery shows scenes with their pictures, titles and sentences.
TEST_F(ScreenshotsTest, GalleryOfThreeScenes) {
  const fs::path scenes = folder_ / "scenes";
  fs::create_directories(scenes / "pictures");
  const std::pair<const char*, Rgb> kinds[] = {
      {"palpation", {190, 90, 70}}, {"incision", {230, 180, 150}}, {"flag", {60, 110, 190}}};
  for (const auto& [name, color] : kinds) {
    std::ofstream(scenes / (std::string(name) + ".toml"))
        << "# A scene of " << name << " for a test.\n[world]\n";
    ASSERT_TRUE(write_png(scenes / "pictures" / (std::string(name) + ".png"),
                          painted(make_image(400, 240, color), 100, 60, 300, 180, {240, 240, 240})));
  }
  setenv("TURGOR_SCENES", scenes.c_str(), 1);
  open_at_full_size("");
  if (!IsSkipped()) draw_for(0.3);
  unsetenv("TURGOR_SCENES");
  if (IsSkipped()) return;
  hand("mousemove 700 780");
  draw_for(0.1);
  compare("gallery", {"gallery", "side panel", "##MainMenuBar"});
}

/// Pixels of a panel in the color of failures.
int failure_pixels(const Image& image, const ImGuiWindow& window) {
  const ImVec4 failure = failure_color();
  const auto is_near = [](std::uint8_t a, float b) { return std::abs(double(a) - 255 * double(b)) < 12; };
  const ImRect at = window.Rect();
  int count = 0;
  for (int y = std::max(0, int(at.Min.y)); y < std::min(image.height, int(at.Max.y)); y++)
    for (int x = std::max(0, int(at.Min.x)); x < std::min(image.width, int(at.Max.x)); x++) {
      const Rgb p = image.at(x, y);
      count += is_near(p.r, failure.x) && is_near(p.g, failure.y) && is_near(p.b, failure.z);
    }
  return count;
}

// A scene that cannot be loaded is reported in red, in both themes.
TEST_F(ScreenshotsTest, FailuresAreRed) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  draw_for(0.1);
  EXPECT_EQ(failure_pixels(screenshot(), *panel("status")), 0);
  const fs::path broken = folder_ / "broken.toml";
  std::ofstream(broken) << "[body.pad]\nmodel = \"unknown\"\n";
  open_file(viewer(), broken);
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.phase == SessionStatus::Phase::kFailed; }));
  for (const Theme theme : {Theme::kDark, Theme::kLight}) {
    viewer().settings.appearance.theme = theme;
    draw_for(0.1);
    EXPECT_GT(failure_pixels(screenshot(), *panel("status")), 50);
  }
}

}  // namespace
}  // namespace turgor

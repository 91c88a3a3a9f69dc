// Stitches and needles by hand: preview, force, undo, saved scenes, depth and layer.
#include "tests/window/window_test.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

class SutureToolsTest : public WindowTest {
 protected:
  Viewer& viewer() { return window_->viewer(); }
  void click(Vec3d point) {
    hand("mousemove " + pixel(point) + " mousedown 1");
    draw_for(0.1);
    hand("mouseup 1");
    draw_for(0.1);
  }
  /// Moves the mouse up from its position, in small steps.
  void drag_up(int pixels) {
    for (int n = 0; n < 4; n++) hand(fmt::format("mousemove_relative -- 0 {}", -pixels / 4)), draw_for(0.1);
  }
};

/// The block whose cut is made at once.
fs::path cut_block(const fs::path& folder) {
  EXPECT_TRUE(write_ct(folder / "block.nii", block_ct()));
  std::ofstream(folder / "block.toml") << block_scene_text("block.nii");
  return folder / "block.toml";
}

// Two clicks stitch the wound, a drag pulls the thread, undo takes both back, and the saved scene has the
// stitch.
TEST_F(SutureToolsTest, ClicksStitchAndDragPulls) {
  open(cut_block(folder_));
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.snapshot.frame > 10; }));
  type("1");
  type("k");
  ASSERT_EQ(viewer().mode, MouseMode::kSuture);
  viewer().stitches.until_closed = false, viewer().stitches.tension = 0.2;
  const Vec3d left{-0.010, -0.02, 0.004}, right{0.014, -0.02, 0.004};
  click(left);
  ASSERT_TRUE(viewer().stitch) << viewer().message;
  hand("mousemove " + pixel(right));
  draw_for(0.1);
  ASSERT_TRUE(viewer().stitch->to) << "the preview";
  EXPECT_LT(norm(viewer().stitch->to->now - right), 0.003) << "m";
  hand("mousedown 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) {
    return n.stitches.size() == 1 && n.stitches[0].phase == lattice::StitchPhase::kKnotted;
  })) << viewer().message
      << now().error;
  EXPECT_NEAR(now().stitches[0].tension, 0.2, 0.03) << "N";
  EXPECT_NE(stitch_text(now().stitches[0]).find("knotted"), std::string::npos);
  // drag
  const double gape = now().stitches[0].gape;
  drag_up(60);
  hand("mouseup 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) {
    return n.stitches[0].request.tension.value_or(0) > 0.4 &&
           n.stitches[0].phase == lattice::StitchPhase::kKnotted;
  })) << viewer().message;
  EXPECT_LT(now().stitches[0].gape, gape);
  EXPECT_FALSE(viewer().pulled);
  // save
  type("s");
  const Result<Scene> saved = read_scene(folder_ / "block-1.toml");
  ASSERT_TRUE(saved) << viewer().message << saved.error().message;
  ASSERT_EQ(saved->sutures.size(), 1u);
  EXPECT_EQ(saved->sutures[0].incision, 0);
  EXPECT_NEAR(saved->sutures[0].pull.tension, *now().stitches[0].request.tension, 1e-4);
  EXPECT_GT(saved->duration, saved->sutures[0].pull.start);
  // undo
  type("ctrl+z");
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return n.stitches[0].request.tension == 0.2; }));
  type("ctrl+z");
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return n.stitches.empty(); }));
}

// Points on one side of the wound give a message, and Esc forgets the first point.
TEST_F(SutureToolsTest, RefusedStitchGivesReason) {
  open(cut_block(folder_));
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.snapshot.frame > 10; }));
  type("1");
  type("k");
  click({0.014, -0.02, 0.004});
  ASSERT_TRUE(viewer().stitch);
  type("Escape");
  EXPECT_FALSE(viewer().stitch);
  click({0.014, -0.02, 0.004});
  click({0.030, -0.02, 0.004});
  EXPECT_TRUE(
      draw_until([](const SessionStatus& n) { return n.error.find("both sides") != std::string::npos; }));
  EXPECT_TRUE(now().stitches.empty());
}

/// A needle that waits above the pad.
constexpr const char* kWaitingNeedle = R"([tool.needle]
body = "pad"
shape = { needle = 0.06, diameter = 0.001 }
press = { at = [0.031, 0.028, 0.04], depth = 0.02, start = 1000 }
)";

// A needle is pushed by a drag, the wheel and a key; the panel names depth, force and layer; Esc withdraws
// it.
TEST_F(SutureToolsTest, NeedleReadsDepthForceAndLayer) {
  open(pad(folder_, kWaitingNeedle));
  ASSERT_TRUE(wait_for_world());
  EXPECT_EQ(needle_text(viewer()), "");
  type("5");  // from above
  const auto inserted = [](const SessionStatus& n) {
    return n.haptic[0].empty() ? 0.0 : n.haptic[0].back().needle.inserted;
  };
  hand("mousemove " + pixel({0.031, 0.028, 0.04}) + " mousedown 1");
  draw_for(0.3);
  ASSERT_TRUE(viewer().touching && viewer().touching->needle);
  EXPECT_EQ(inserted(now()), 0) << "it waits above the skin";
  for (int n = 0; n < 4; n++) hand("mousemove_relative 0 30"), draw_for(0.1);
  ASSERT_TRUE(draw_until([&](const SessionStatus& n) { return inserted(n) > 0.004; })) << inserted(now());
  EXPECT_NE(needle_text(viewer()).find("tip in pad"), std::string::npos) << needle_text(viewer());
  EXPECT_GT(now().haptic[0].back().force, 0.05) << "N";
  hand("mouseup 1");
  draw_for(0.2);
  ASSERT_TRUE(viewer().touching) << "it stays when the button is released";
  for (int n = 0; n < 3; n++) hand("click --repeat 4 4"), draw_for(0.1);
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.layers[0] == "nodule"; }))
      << needle_text(viewer());
  // withdraw
  draw_for(0.5);
  const double goal = viewer().touching->needle->goal;
  type("Prior Prior Prior");
  EXPECT_NEAR(viewer().touching->needle->goal, goal - 0.003, 1e-9);
  EXPECT_TRUE(draw_until([&](const SessionStatus&) { return viewer().touching->depth < goal - 0.0029; }));
  type("Escape");
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return inserted(n) == 0; }));
  EXPECT_TRUE(draw_until([&](const SessionStatus&) { return !viewer().touching; }));
  EXPECT_EQ(viewer().mode, MouseMode::kTouch);
}

}  // namespace
}  // namespace turgor

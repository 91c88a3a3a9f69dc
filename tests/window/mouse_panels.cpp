// Sliders, fields and buttons of the side panel of a real window, by mouse.
#include "tests/window/panel_hand.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

class MousePanelsTest : public PanelTest {
 protected:
  /// Drags the item below the mouse to the right [pixels].
  void drag_right(int pixels) {
    press();
    for (int n = 0; n < 4; n++) hand(fmt::format("mousemove_relative -- {} 0", pixels / 4)), draw_twice();
    release();
  }
  /// The parameter as listed in the panel.
  const Parameter& parameter(const std::string& path) {
    const ParameterList& list = viewer().parameters;
    const auto found =
        std::find_if(list.begin(), list.end(), [&](const Parameter& one) { return one.key.path == path; });
    EXPECT_NE(found, list.end()) << path;
    return *found;
  }
};

// The depth slider of the cut mode sets the depth of the next cut.
TEST_F(MousePanelsTest, DepthSliderSetsDepthOfCut) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("1");
  ASSERT_TRUE(click_item(side(), {"cut"}));
  ASSERT_EQ(viewer().mode, MouseMode::kCut);
  ASSERT_TRUE(point_at(side(), {"##depth"}));
  const double before = viewer().cut_depth;
  drag_right(60);
  const double depth = viewer().cut_depth;
  EXPECT_GT(depth, 1.2 * before) << "m";
  hand("mousemove " + pixel({0.01, -0.02, -0.03}) + " mousedown 1");
  draw_for(0.1);
  hand("mousemove " + pixel({0.01, -0.02, 0.03}));
  draw_for(0.1);
  hand("mouseup 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.cut_result.is_measured; }))
      << viewer().message;
  EXPECT_NEAR(now().cut_result.depth, depth, 1e-9);
}

// A parameter is found by a search, changed by a drag while the scene runs, and reset by its button.
TEST_F(MousePanelsTest, ParameterIsDraggedAndReset) {
  open(pad(folder_, kPressingFinger));
  ASSERT_TRUE(wait_for_world());
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.snapshot.time > 0.3; }));
  const double soft = force(now());
  ASSERT_GT(soft, 0.01) << "N";
  ASSERT_TRUE(click_item(side(), {"Forces"}));
  ASSERT_TRUE(click_item(side(), {"Parameters"}));
  ASSERT_TRUE(viewer().panels.parameters && !viewer().panels.curves);
  ASSERT_TRUE(click_item(side(), {"##filter"}));
  hand("type stiffness_scale");
  draw_for(0.3);
  ASSERT_EQ(viewer().parameter_filter, "stiffness_scale");
  ASSERT_TRUE(point_at(side(), {"body.pad", "body.pad.stiffness_scale", "##value", kFirstNumber}));
  drag_right(160);
  draw_for(0.2);
  const double times = parameter("body.pad.stiffness_scale").value[0];
  EXPECT_GT(times, 1.5);
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) {
    return std::abs(force(n) - times * soft) < 0.05 * times * soft;
  })) << force(now())
      << " N of " << soft << " times " << times;
  ASSERT_TRUE(click_item(side(), {"body.pad", "body.pad.stiffness_scale", "Reset"}));
  EXPECT_TRUE(draw_until([&](const SessionStatus& n) { return std::abs(force(n) - soft) < 0.05 * soft; }));
  draw_for(0.1);
  EXPECT_FALSE(parameter("body.pad.stiffness_scale").is_changed);
}

// Play, pace and the status line's details are buttons.
TEST_F(MousePanelsTest, ButtonsPauseSlowAndExplain) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  ASSERT_TRUE(click_item(side(), {"Pause##play"}));
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return !n.plays; }));
  ASSERT_TRUE(click_item(side(), {"Slower"}));
  EXPECT_TRUE(draw_until([](const SessionStatus& n) { return n.pace == 0.5; }));
  const std::string word = status_word(viewer()).text;
  EXPECT_EQ(word, "Running") << "another pace plays";
  ASSERT_TRUE(click_item(panel("status"), {word + "##status"}));
  draw_twice();
  EXPECT_TRUE(popup()) << "the details";
}

}  // namespace
}  // namespace turgor

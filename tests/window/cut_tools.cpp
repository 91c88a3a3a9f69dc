// Cuts by hand: preview, depth, result, copied points and markups of 3D Slicer.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "tests/window/window_test.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

class CutToolsTest : public WindowTest {
 protected:
  Viewer& viewer() { return window_->viewer(); }
  void draw_line(Vec3d from, Vec3d to) {
    hand("mousemove " + pixel(from) + " mousedown 1");
    draw_for(0.1);
    hand("mousemove " + pixel(to));
    draw_for(0.1);
  }
};

// The line is shown on the skin while it is drawn, the wheel sets the depth, and the result is reported.
TEST_F(CutToolsTest, PreviewDepthAndResult) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("1");
  type("c");
  draw_line({0.01, -0.02, -0.03}, {0.01, -0.02, 0.03});
  ASSERT_TRUE(viewer().cut);
  EXPECT_NEAR(viewer().cut->on_skin.length, 0.06, 0.004) << "m";
  const double depth = viewer().cut_depth;
  hand("click 4 click 4");
  draw_for(0.1);
  EXPECT_NEAR(viewer().cut_depth, depth + 0.002, 1e-9);
  hand("mouseup 1");
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.cut_result.is_measured; }));
  EXPECT_NEAR(now().cut_result.depth, depth + 0.002, 1e-9);
  EXPECT_NE(cut_text(now().cut_result).find("12.0 mm deep"), std::string::npos) << cut_text(now().cut_result);
}

// A copied point is a position of the scene at rest.
TEST_F(CutToolsTest, CopiedPointIsInSceneCoordinates) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  type("1");
  hand("mousemove " + pixel({0.01, -0.02, 0.03}));
  draw_for(0.1);
  type("ctrl+c");
  const char* copied = glfwGetClipboardString(glfwGetCurrentContext());
  ASSERT_TRUE(copied);
  double x = 0, y = 0, z = 0;
  ASSERT_EQ(std::sscanf(copied, "[%lf, %lf, %lf]", &x, &y, &z), 3) << copied;
  EXPECT_LT(norm(Vec3d{x, y, z} - Vec3d{0.01, -0.02, 0.03}), 0.003) << copied;
}

fs::path line_file(const fs::path& folder) {
  const fs::path file = folder / "cut.mrk.json";
  std::ofstream(file) << R"({"markups": [{"type": "Line", "coordinateSystem": "RAS", "controlPoints": [
    {"position": [-10, 20, -30], "positionStatus": "defined"},
    {"position": [-10, 20, 30], "positionStatus": "defined"}]}]})";
  return file;
}

// A dropped line of 3D Slicer cuts the body.
TEST_F(CutToolsTest, DroppedMarkupCuts) {
  open(block(folder_));
  ASSERT_TRUE(wait_for_world());
  GLFWwindow* window = glfwGetCurrentContext();
  const GLFWdropfun dropped = glfwSetDropCallback(window, nullptr);
  glfwSetDropCallback(window, dropped);
  const fs::path file = line_file(folder_);
  const char* files[] = {file.c_str()};
  dropped(window, 1, files);
  ASSERT_TRUE(draw_until([](const SessionStatus& n) { return n.cuts.size() == 1; })) << viewer().message;
  EXPECT_LT(norm(now().cuts[0].from - Vec3d{0.01, -0.02, -0.03}), 1e-9);
  EXPECT_TRUE(draw_until([](const SessionStatus& n) {
    return n.snapshot.bodies[0].triangles.size() > n.snapshot.bodies[0].wall_begin + 30;
  }));
}

// A scene without a lattice has nothing to cut.
TEST_F(CutToolsTest, MarkupWithoutLatticeIsReported) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  open_file(viewer(), line_file(folder_));
  EXPECT_NE(viewer().message.find("expected a scene with a lattice"), std::string::npos) << viewer().message;
  EXPECT_EQ(viewer().message, viewer().failure);
}

// A click on the cube's front face shows the front.
TEST_F(CutToolsTest, CubeTurnsTheView) {
  open(liver(folder_));
  ASSERT_TRUE(wait_for_world());
  type("3");
  draw_for(0.1);
  const Area& area = viewer().area;
  const double size = 80;
  hand(fmt::format("mousemove {:.0f} {:.0f}", area.x + area.width - 8 - size / 2, area.y + 8 + size / 2));
  draw_for(0.1);
  const Camera before = viewer().camera;
  hand("mousedown 1");
  draw_for(0.1);
  hand(
      fmt::format("mousemove {:.0f} {:.0f}", area.x + area.width - 8 - size / 2 + 40, area.y + 8 + size / 2));
  draw_for(0.1);
  hand("mouseup 1");
  draw_for(0.1);
  EXPECT_GT(norm(viewer().camera.eye - before.eye), 0.05) << "a drag orbits";
  type("3");
  draw_for(0.1);
  type("2");
  draw_for(0.1);
  hand(fmt::format("mousemove {:.0f} {:.0f}", area.x + area.width - 8 - size / 2, area.y + 8 + size / 2));
  type("3");
  const Camera right = viewer().camera;
  viewer().camera = orbited(right, 0.3, 0.2);
  draw_for(0.1);
  hand("mousedown 1");
  draw_for(0.1);
  hand("mouseup 1");
  draw_for(0.1);
  EXPECT_LT(norm(viewer().camera.eye - right.eye), 1e-9) << "a click on R views from the right";
}

}  // namespace
}  // namespace turgor

#include "turgor/view/drawing_process.hpp"

#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/refused.hpp"
#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

constexpr Camera kFront{.eye = {0, -1, 0}, .target = {0, 0, 0}};
constexpr const char* kServes = "TURGOR_TEST_SERVES_DRAWINGS";

// This test program draws for its parent if that asks for it.
const bool is_parent = [] {
  if (std::getenv(kServes)) _exit(serve_drawings());
  return true;
}();

/// Uses a program for the pictures of a test.
class DrawingProcess : public testing::Test {
 protected:
  void TearDown() override {
    set_drawing_program({});
    unsetenv(kServes);
  }
  Result<Image> draw(RenderQuality quality = RenderQuality::kFull) const {
    const ColorScale scale{0, 1, "pressure [kPa]", 1};
    TriMesh colored = test::sphere({-0.1f, 0, 0}, 0.08f, 3), plain = test::sphere({0.1f, 0, 0}, 0.08f, 3);
    for (const Vec3 p : colored.vertices) colored.scalars.push_back(5 * p.z + 0.5f);
    const FacePicture picture{.corner = {0.06, 0, -0.04},
                              .right = {0.02, 0, 0},
                              .up = {0, 0, 0.02},
                              .image = {2, 2, {{200, 0, 0}, {0, 200, 0}, {0, 0, 200}, {200, 200, 200}}}};
    const std::vector<Rgb> colors(plain.vertices.size(), Rgb{20, 190, 20});
    return draw_meshes({{.mesh = &colored, .scale = &scale},
                        {.mesh = &plain, .colors = &colors, .see_through = true, .closed = true, .wet = true},
                        {.mesh = &plain,
                         .cutaway = {1, {{{0.1, 0, 0}, {0, -1, 0}}}},
                         .is_cut_face = true,
                         .face_pictures = {picture}}},
                       kFront, 300, 200, quality);
  }
};

// A child draws the same pixels as this process, several pictures in turn.
TEST_F(DrawingProcess, ChildDrawsSamePixels) {
  ASSERT_TRUE(is_parent);
  for (const RenderQuality quality : {RenderQuality::kFull, RenderQuality::kQuick}) {
    set_drawing_program({});
    const Result<Image> in_parent = draw(quality);
    if (!in_parent) GTEST_SKIP() << in_parent.error().message;
    setenv(kServes, "1", 1);
    set_drawing_program({.arguments = {"/proc/self/exe"}});
    for (int pass = 0; pass < 2; pass++) {
      const Result<Image> in_child = draw(quality);
      ASSERT_TRUE(in_child) << in_child.error().message;
      EXPECT_TRUE(in_child->pixels == in_parent->pixels);
    }
  }
}

// A child that was warmed up draws the same pixels, after the thread that waited for it has ended. Without a
// program, or with one that fails, nothing happens.
TEST_F(DrawingProcess, WarmedUpChildDrawsSamePixels) {
  EXPECT_FALSE(warm_up_drawing().valid());
  const Result<Image> in_parent = draw();
  if (!in_parent) GTEST_SKIP() << in_parent.error().message;
  set_drawing_program({.arguments = {"/no/such/program"}});
  EXPECT_FALSE(warm_up_drawing().valid());
  setenv(kServes, "1", 1);
  set_drawing_program({.arguments = {"/proc/self/exe"}});
  warm_up_drawing().get();
  const Result<Image> in_child = draw();
  ASSERT_TRUE(in_child) << in_child.error().message;
  EXPECT_TRUE(in_child->pixels == in_parent->pixels);
}

// A child that crashes, ends, hangs or is missing gives an error and not the end of this process.
TEST_F(DrawingProcess, FailedChildGivesError) {
  set_drawing_program({.arguments = {"/bin/sh", "-c", "head -c 8 >/dev/null; kill -SEGV $$"}});
  EXPECT_REFUSED(draw(), "cannot draw: the process that draws crashed (Segmentation fault)", "ulimit -v");
  set_drawing_program({.arguments = {"/bin/sh", "-c", "head -c 8 >/dev/null; exit 7"}});
  EXPECT_REFUSED(draw(), "the process that draws ended with status 7");
  set_drawing_program({.arguments = {"/bin/sh", "-c", "cat >/dev/null"}, .patience = 0.3});
  EXPECT_REFUSED(draw(), "gave no picture for 0.3 s and was stopped");
  set_drawing_program({.arguments = {"/no/such/program"}});
  EXPECT_REFUSED(draw(), "the process that draws cannot be started: No such file or directory");
}

// A child is killed with the thread that started it. Another thread then draws with a child of its own.
TEST_F(DrawingProcess, ChildOfEndedThreadIsReplaced) {
  if (!draw()) GTEST_SKIP() << "no OpenGL";
  setenv(kServes, "1", 1);
  set_drawing_program({.arguments = {"/proc/self/exe"}});
  for (int pass = 0; pass < 2; pass++) {
    bool has_drawn = false;
    std::thread([&] { has_drawn = bool(draw()); }).join();
    EXPECT_TRUE(has_drawn) << pass;
    usleep(20000);  // the signal arrives
  }
  const Result<Image> last = draw();
  EXPECT_TRUE(last) << last.error().message;
}

// A fork leaves its parent's child alone and starts its own.
TEST_F(DrawingProcess, ForkHasItsOwnChild) {
  if (!draw()) GTEST_SKIP() << "no OpenGL";
  setenv(kServes, "1", 1);
  set_drawing_program({.arguments = {"/proc/self/exe"}});
  ASSERT_TRUE(draw());
  const pid_t fork_of_this = fork();
  if (fork_of_this == 0) {
    const bool has_drawn = bool(draw());
    set_drawing_program({});
    _exit(has_drawn ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(fork_of_this, &status, 0), fork_of_this);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  const Result<Image> again = draw();
  EXPECT_TRUE(again) << again.error().message;
}

// A refusal to start a program is given as the reason, and nothing is drawn in this process.
TEST_F(DrawingProcess, RefusalIsNamed) {
  set_drawing_program({.refusal = "no program"});
  EXPECT_REFUSED(draw(), "cannot draw: no program");
  EXPECT_FALSE(warm_up_drawing().valid());
}

// An error of the child's drawing arrives with its text, and the child draws on.
TEST_F(DrawingProcess, ChildReportsItsErrors) {
  setenv(kServes, "1", 1);
  const Result<Image> in_parent = draw_meshes({}, kFront, 1 << 20, 8);
  if (!draw()) GTEST_SKIP() << "no OpenGL";
  set_drawing_program({.arguments = {"/proc/self/exe"}});
  EXPECT_REFUSED(draw_meshes({}, kFront, 1 << 20, 8), in_parent.error().message);
  EXPECT_TRUE(draw());
}

}  // namespace
}  // namespace turgor

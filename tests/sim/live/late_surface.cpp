// Surface of a body that is cut while a tool is away from it: frames leave the surface as it was, and the
// state has the same bits as with a surface that is made for every cut.
#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "turgor/contact/lattice_touch.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/live/mouse_tools.hpp"

namespace turgor {
namespace {

constexpr int kRunFrames = 22, kTicks = 20;  // frames of 20 ms

/// A block that is cut during ten frames, with a fingertip whose commands come from ticks.
struct TickedBlock {
  Exec exec{1};
  World world;
  double y = -0.09;  // of the fingertip's center; the front is at -0.02 [m]

  TickedBlock()
      : world(test::block_world(
            exec, with_mouse_tools(test::block_scene(
                      test::fresh_folder(), {"incision.cut.start=0.02", "incision.cut.duration=0.2"})))) {
    begin_haptics(body(), world.tools);
  }
  LatticeBody& body() { return world.lattice_bodies[0]; }
  bool is_stale() { return body().surface_cuts != cut_version(body().state.cuts()); }

  /// Moves the tool towards the wound, and steps.
  void play_frame(double last) {
    const double from = y, to = std::min(last, y + 0.0035);
    for (int tick = 1; tick <= kTicks; tick++) {
      y = from + (to - from) * tick / kTicks;
      const contact::ToolCommand command{.pose = {.position = {0.004, y, 0}}};
      contact::ToolReading reading;
      tick_haptics(body(), std::span(&command, 1), 0.001, std::span(&reading, 1));
    }
    ASSERT_TRUE(step(exec, world));
  }
};

// No sample of the present surface is near the tool in a frame that leaves the surface as it was.
TEST(LateSurface, SkippedSurfacesTouchNothing) {
  TickedBlock block;
  int stale = 0, touched = 0;
  for (int frame = 0; frame < kRunFrames; frame++) {
    block.play_frame(-0.025);
    touched += !block.body().touch.contacts.empty();
    if (!block.is_stale()) continue;
    stale++;
    LatticeBody fresh = block.body();
    refresh_surface(block.exec, fresh);
    EXPECT_TRUE(
        contact::samples_near(fresh.model, fresh.state, fresh.touch, fresh.tools, fresh.poses).empty())
        << "frame " << frame;
  }
  EXPECT_GE(stale, 3);
  EXPECT_GE(touched, 3);
}

// Surfaces that are made after every frame change no bit of the state, in the wound and far from it.
TEST(LateSurface, StateHasSameBits) {
  for (const double last : {-0.08, -0.014}) {
    TickedBlock late, prompt;
    for (int frame = 0; frame < kRunFrames; frame++) {
      late.play_frame(last), prompt.play_frame(last);
      refresh_surface(prompt.exec, prompt.body());
    }
    EXPECT_EQ(state_hash(late.world), state_hash(prompt.world)) << last << " m";
    EXPECT_EQ(late.is_stale(), last < -0.05);
    refresh_surface(late.exec, late.body());
    EXPECT_EQ(late.body().touch.samples.size(), prompt.body().touch.samples.size());
    EXPECT_TRUE(late.body().surface.triangles == prompt.body().surface.triangles);
  }
}

}  // namespace
}  // namespace turgor

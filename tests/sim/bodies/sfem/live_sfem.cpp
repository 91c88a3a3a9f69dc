// A haptic thread, while another thread computes the frames.
#include <atomic>
#include <chrono>
#include <thread>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/pressed.hpp"

namespace turgor {
namespace {

/// Forces on a tool that follows its path until `end`, ticked by a thread that never blocks.
struct LiveHand {
  const SfemBody& body;
  contact::SfemTouch& touch;
  contact::SfemExchange& exchange;
  TouchingTool tool;  // a copy
  TouchLog log;
  double steepest = 0;  // [N per tick]
  std::atomic<bool> done = false;
  // On a slow machine, too, the hand is at most one frame ahead, and the frames are never ahead of the hand.
  std::atomic<long> ticks = 0, frames = 0;

  void run(double end) {
    log.preallocate(std::size_t(end / kTick) + 1);
    std::vector<contact::ToolReading> readings(1);
    Vec3d before;
    for (long i = 1; double(i) * kTick <= end; i++) {
      const contact::ToolCommand command = next_command(tool, double(i) * kTick, kTick);
      contact::tick_with_exchange(touch, exchange, std::span(&command, 1), kTick, readings);
      log.append(sample_of(double(i) * kTick, command, readings[0]));
      if (i > 1) steepest = std::max(steepest, norm(readings[0].force - before));
      before = readings[0].force;
      ticks = i;
      while (i >= 17 * (frames + 1)) std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    done = true;
  }
};

void expect_like_offline(const std::string& keys, const std::vector<std::string>& overrides) {
  const Scene scene = test::body_scene(test::fresh_folder(), keys, overrides);
  World offline = test::sfem_world(Exec(1), scene), live = test::sfem_world(Exec(1), scene);
  constexpr double kEnd = 0.3, kFrame = 1.0 / 60;
  std::vector<Pressed> pressed = make_pressed(offline);
  for (int frame = 0; frame < 18; frame++) {
    ASSERT_TRUE(step(Exec(1), offline));
    update_pressed(Exec(1), offline, pressed);
  }

  SfemBody& body = live.sfem_bodies[0];
  contact::SfemExchange exchange;
  contact::prepare(body.touch, exchange);
  LiveHand hand{body, body.touch, exchange, live.tools[0], {}};
  std::thread haptic_thread([&] { hand.run(kEnd); });
  int pictures = 0;
  while (!hand.done) {
    while (!hand.done && hand.ticks < 17 * hand.frames)
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    make_frame(Exec(1), body, double(hand.frames) * kFrame, kFrame, exchange);
    BodySnapshot snapshot;
    show(Exec(1), body, snapshot);
    pictures += snapshot.pressure.empty() ? 0 : 1;
    while (body.worker && body.worker->is_busy() && !body.worker->is_ready())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    hand.frames++;
  }
  haptic_thread.join();
  make_frame(Exec(1), body, kEnd, kFrame, exchange);

  ASSERT_EQ(hand.log.size(), 300u) << "no tick is skipped";
  EXPECT_EQ(hand.log.missed(), 0u);
  EXPECT_EQ(pictures, hand.frames);
  EXPECT_GE(body.touch.patch_number, 2) << "the patch followed";
  const auto &samples = offline.tools[0].samples, &haptic = hand.log;
  const double largest = pressed[0].force;
  double off = 0;
  for (std::size_t i = 0; i < 295; i++) off = std::max(off, norm(samples[i].force - haptic[i].force));
  std::printf("%ld patches, %ld frames; largest %.4f N, apart by up to %.4f N, %.4f N a tick\n",
              body.touch.patch_number, long(hand.frames), largest, off, hand.steepest);
  // Patches start when they are ready, not at a fixed tick. If one starts a frame late, the tool is beyond
  // the old one. Its jump is blended in, by at most this much per tick.
  EXPECT_LT(off, 0.4 * largest);
  EXPECT_LT(hand.steepest, 0.1 * largest + contact::FollowParams().largest_step);
  EXPECT_LE(body.patches.size(), std::size_t(body.touch.patch_number) + 1);
}

// A haptic thread receives the forces of an offline run.
TEST(LiveSfem, HapticThreadMatchesOfflineRun) { expect_like_offline("", {}); }

// This also holds while another thread updates rotations and computes columns on demand.
TEST(LiveSfem, HapticThreadMatchesRotatingBody) {
  expect_like_offline("rotations = true\n", {"body.pad.memory=0.004"});
}

// Patches that are no longer in use are freed.
TEST(LiveSfem, UnusedPatchesAreFreed) {
  World world = test::sfem_world(Exec(1), test::body_scene(test::fresh_folder()));
  for (int frame = 0; frame < 18; frame++) ASSERT_TRUE(step(Exec(1), world));
  const SfemBody& body = world.sfem_bodies[0];
  ASSERT_GT(body.rebuilds.size(), 2u);
  EXPECT_LE(body.patches.size(), 2u);
}

}  // namespace
}  // namespace turgor

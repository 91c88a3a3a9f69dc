#include "turgor/contact/sfem_touch.hpp"

#include <atomic>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "tests/contact/soft_block.hpp"

namespace turgor::contact {
namespace {

constexpr double kRadius = 5e-3, kTick = 1e-3;
const std::vector<Tool> kBall{{Sphere{kRadius}, 0.4}};
const FollowParams kFollow{.radius = 12e-3, .blend_time = 0.03, .largest_step = 2e-3};

std::shared_ptr<const sfem::Patch> patch_at(Vec3d position) {
  const std::vector<Vec3d> positions{position};
  return std::make_shared<const sfem::Patch>(*sfem::build_patch(
      soft_block(), sfem::patch_elements(soft_block(), positions, kFollow.radius), 2, positions));
}

Pose pose_above(double x, double depth) { return {{x, 1e-3, kRadius - depth}, {}}; }

SfemTouch touched(double stiffening = 0) {
  const std::vector<Pose> poses{pose_above(-10e-3, -1e-3)};
  return make_sfem_touch(patch_at({-10e-3, 0, 0}), kBall, poses,
                         {.touch = {.viscosity = one_pair(stiffening, 0.1)},
                          .follow = kFollow,
                          .vertex_count = soft_block().body.mesh.vertices.size()});
}

/// Down within 100 ms, then along x by 10 µm per tick.
ToolCommand command_at(int tick) {
  return {.pose = pose_above(-10e-3 + 1e-5 * std::max(0, tick - 100), 2e-3 * std::min(1.0, tick / 100.0))};
}

// A tick that receives a frame and a patch allocates no memory.
TEST(SfemTouch, TicksAllocateNothing) {
  for (const double stiffening : {0.0, 1.0}) {
    SfemTouch touch = touched(stiffening);
    SfemExchange exchange;
    prepare(touch, exchange);
    std::vector<std::shared_ptr<const sfem::Patch>> alive{touch.patch};
    std::vector<ToolReading> readings(1);
    std::size_t counted = 0;
    for (int i = 0; i < 900; i++) {
      if (i % 17 == 0) {
        exchange.motion.write({std::vector<Vec3d>(touch.free.to.size(), Vec3d{0, 0, 1e-6 * i}), 17});
      }
      if (i % 200 == 150) {
        const SfemTouchSnapshot now = exchange.touched.read();
        alive.push_back(patch_at(now.contact_centers[0].position));
        exchange.patches.write(
            {alive.back(), transferred_history(soft_block(), now.history, *now.patch, *alive.back()), i});
      }
      const ToolCommand command = command_at(i);
      counted += test::allocations_of(
          [&] { tick_with_exchange(touch, exchange, std::span(&command, 1), kTick, readings); });
    }
    EXPECT_EQ(counted, 0u) << stiffening;
    EXPECT_EQ(touch.patch_number, 750) << "the last patch";
    EXPECT_GT(readings[0].force.z, 0.01) << "N: the ball still presses";
  }
}

// A tick in which pairs come into use or go allocates no memory either, nor does the patch that follows.
TEST(SfemTouch, ChangedViscosityAllocatesNothing) {
  SfemTouch touch = touched();
  SfemExchange exchange;
  reserve_viscosity(touch);
  prepare(touch, exchange);
  const Prony laws[] = {one_pair(0.5, 0.1), {{{{0.8, 0.1}, {0.5, 1}, {0.3, 10}}}}, {}};
  std::vector<std::shared_ptr<const sfem::Patch>> alive{touch.patch};
  std::vector<ToolReading> readings(1);
  std::size_t counted = 0;
  for (int i = 0; i < 300; i++) {
    if (i % 50 == 20)
      exchange.motion.write({.to = {}, .ticks = 17, .viscosity = laws[std::size_t(i / 50 % 3)], .number = i});
    if (i % 50 == 22) {  // offered before the change reached its snapshot, every other time
      const SfemTouchSnapshot now = exchange.touched.read();
      alive.push_back(patch_at(now.contact_centers[0].position));
      const ViscousHistory known = i % 100 == 22 ? now.history : ViscousHistory{};
      exchange.patches.write(
          {alive.back(), transferred_history(soft_block(), known, *now.patch, *alive.back()), i});
    }
    const ToolCommand command = command_at(i);
    counted += test::allocations_of(
        [&] { tick_with_exchange(touch, exchange, std::span(&command, 1), kTick, readings); });
    EXPECT_TRUE(is_finite(readings[0].force));
  }
  EXPECT_EQ(counted, 0u);
  EXPECT_EQ(touch.state.history.count, 0);
  EXPECT_GT(readings[0].force.z, 0.01) << "N: the ball still presses";
}

// The surface moves linearly and reaches the positions of a frame at the frame's last tick.
TEST(SfemTouch, SurfaceReachesFrameAtLastTick) {
  SfemTouch touch = touched();
  const std::vector<ToolCommand> away{{.pose = pose_above(0, -0.1)}};
  std::vector<ToolReading> readings(1);
  const Vec3d goal{1e-3, 0, 2e-3}, second{0, 0, -1e-3};
  const auto move_to = [&](Vec3d to, int ticks) {
    take_free_motion(touch, std::vector<Vec3d>(touch.free.to.size(), to), 10);
    for (int i = 0; i < ticks; i++) tick_sfem_touch(touch, away, kTick, readings);
    return touch.state.x[0] - touch.patch->points[0].x;
  };
  EXPECT_LT(norm(move_to(goal, 10) - goal), 1e-15);
  EXPECT_LT(norm(move_to(second, 5) - (goal + second) / 2), 1e-15) << "halfway";
  EXPECT_LT(norm(move_to(goal, 5) - ((goal + second) / 2 + goal) / 2), 1e-15)
      << "from its last position, without a jump";
  EXPECT_LT(norm(move_to(second, 30) - second), 1e-15) << "and stays at rest";
}

// A frame takes its duration, also in ticks of another length: after half of it, the surface is halfway.
TEST(SfemTouch, ShortTicksKeepDurationOfFrame) {
  SfemTouch touch = touched();
  SfemExchange exchange;
  prepare(touch, exchange);
  const ToolCommand away{.pose = pose_above(0, -0.1)};
  std::vector<ToolReading> readings(1);
  const Vec3d shift{1e-3, 0, 2e-3};
  exchange.motion.write({.to = std::vector<Vec3d>(touch.free.to.size(), shift), .ticks = 17});
  const auto moved_after = [&](int ticks) {
    for (int i = 0; i < ticks; i++)
      tick_with_exchange(touch, exchange, std::span(&away, 1), kTick / 4, readings);
    return touch.state.offset[0];
  };
  EXPECT_LT(norm(moved_after(34) - shift / 2), 1e-15);
  EXPECT_LT(norm(moved_after(34) - shift), 1e-15);
}

// A reading has the depth, the contacts and a flag for a tool beyond the patch.
TEST(SfemTouch, ReadingHasDepthAndContacts) {
  SfemTouch touch = touched();
  std::vector<ToolReading> readings(1);
  for (int i = 0; i <= 150; i++) {
    const ToolCommand command = command_at(i);
    tick_sfem_touch(touch, std::span(&command, 1), kTick, readings);
  }
  EXPECT_NEAR(readings[0].depth, 2e-3, 1e-5);
  EXPECT_GT(readings[0].contacts, 3);
  EXPECT_FALSE(readings[0].beyond_patch);
  bool beyond = false;
  for (int i = 151; i <= 1800; i++) {
    const ToolCommand command = command_at(i);
    tick_sfem_touch(touch, std::span(&command, 1), kTick, readings);
    beyond = beyond || readings[0].beyond_patch;
  }
  EXPECT_TRUE(beyond) << "17 mm further, beyond the border of a patch of 12 mm";
}

// Two threads exchange whole frames and patches, and the force has no jump. The hand waits rather than leave
// a patch behind that the other thread is slow to replace.
TEST(SfemTouch, TwoThreads_ExchangeWholeFrames) {
  constexpr int kTicks = 2000;
  constexpr double kFarthest = 5e-3;  // of the ball from the center of its patch [m]
  SfemTouch touch = touched();
  SfemExchange exchange;
  prepare(touch, exchange);
  std::vector<std::shared_ptr<const sfem::Patch>> patches{touch.patch};
  std::atomic<double> center = -10e-3;  // x of the patch that was offered last
  std::atomic<long> offered = 0;
  std::atomic<int> done = 0;
  std::size_t counted = 0;
  double steepest = 0;
  std::thread hand([&] {
    std::vector<ToolReading> readings(1);
    Vec3d before;
    for (int i = 0; i < kTicks; i++) {
      const ToolCommand command = command_at(i);
      while (touch.patch_number == offered && command.pose.position.x - center > kFarthest)
        std::this_thread::yield();
      counted += test::allocations_of(
          [&] { tick_with_exchange(touch, exchange, std::span(&command, 1), kTick, readings); });
      if (i > 0) steepest = std::max(steepest, norm(readings[0].force - before));
      before = readings[0].force;
      done = i + 1;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  });
  while (done < kTicks) {
    const SfemTouchSnapshot& now = exchange.touched.read();
    ASSERT_EQ(now.x.size(), now.patch->points.size()) << "a value is whole";
    ASSERT_EQ(now.force.size(), now.patch->points.size());
    exchange.motion.write({std::vector<Vec3d>(soft_block().body.mesh.vertices.size(), Vec3d{}), 17});
    if (now.patch_number == offered && now.contact_centers[0].touches) {
      const Vec3d touched_at = now.contact_centers[0].position;
      patches.push_back(patch_at(touched_at));
      exchange.patches.write({patches.back(), {}, offered + 1});
      center = touched_at.x, offered++;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  hand.join();
  EXPECT_EQ(counted, 0u);
  EXPECT_GT(touch.patch_number, 3) << "patches followed the ball";
  std::printf("%ld patches in %d ticks, largest step of the force %.5f N\n", touch.patch_number, kTicks,
              steepest);
  EXPECT_LT(steepest, 2 * kFollow.largest_step);
}

}  // namespace
}  // namespace turgor::contact

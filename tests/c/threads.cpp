// Calls of the C interface from several threads.
#include <algorithm>
#include <atomic>
#include <thread>

#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/owned_world.hpp"

namespace turgor {
namespace {

using test::finger_at;
using test::kPad;
using test::OwnedWorld;

// A haptic thread receives forces while another thread steps the frames.
TEST(CThreads, HapticThreadRunsBesideFrames) {
  const OwnedWorld c(kPad);
  ASSERT_EQ(tg_touch_begin(c.world), TG_OK) << tg_error();
  std::atomic<bool> ends{false};
  double haptic = 0;
  std::atomic<int> bad{0}, ticks{0};
  std::thread haptic_thread([&] {
    tg_reading reading;
    while (!ends || ticks < 200) {
      const tg_command command = finger_at(0.036 - 1e-5 * std::min(ticks.load(), 300));
      bad += tg_touch_tick(c.world, &command, sizeof command, &reading, sizeof reading) != TG_OK;
      haptic = std::max(haptic, reading.force[2]);
      ticks++;
    }
  });
  for (int frame = 0; frame < 10; frame++) {
    tg_body_info info{sizeof info, nullptr, nullptr, 0, 0, 0};
    EXPECT_EQ(tg_world_step(c.world, 1), TG_OK) << tg_error();
    EXPECT_EQ(tg_body_get_info(c.world, 0, &info), TG_OK) << tg_error();
  }
  ends = true;
  haptic_thread.join();
  EXPECT_EQ(bad, 0);
  EXPECT_GT(haptic, 0.01);
  EXPECT_EQ(tg_touch_end(c.world), TG_OK) << tg_error();
  EXPECT_EQ(tg_touch_begin(c.world), TG_MISUSE);
}

// Steps from two threads at once are refused.
TEST(CThreads, RejectsConcurrentSteps) {
  const OwnedWorld c(kPad);
  std::atomic<int> refused{0}, others{0};
  const auto step = [&] {
    for (int n = 0; n < 300; n++) {
      const tg_status status = tg_world_step(c.world, 1);
      refused += status == TG_MISUSE, others += status != TG_MISUSE && status != TG_OK;
    }
  };
  std::thread beside(step);
  step();
  beside.join();
  EXPECT_GT(refused, 0);
  EXPECT_EQ(others, 0);
}

}  // namespace
}  // namespace turgor

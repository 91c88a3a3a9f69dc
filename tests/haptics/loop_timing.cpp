// Rates of the haptic loop, the pacing of devices, and its report.
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/allocations.hpp"
#include "tests/haptics/still_device.hpp"
#include "tests/haptics/wall_loop.hpp"
#include "turgor/haptics/loop.hpp"
#include "turgor/haptics/real_time.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {
namespace {

using contact::ToolCommand;
using contact::ToolReading;

/// Model whose tick takes 0.2 ms.
struct Slow {
  static constexpr double kWork = 2e-4;  // [s]
  std::atomic<int> ticks = 0;
  static void tick(void* context, std::span<const ToolCommand>, double, std::span<ToolReading>) {
    const double end = steady_seconds() + kWork;
    while (steady_seconds() < end) {
    }
    static_cast<Slow*>(context)->ticks++;
  }
};

// Ticks run at the requested rate, and the report is consistent with it.
TEST(LoopTiming, RunsAtRequestedRate) {
  StillDevice device;
  Slow model;
  const double began = steady_seconds();
  auto loop = Loop::start({{.device = &device}}, Slow::tick, &model, kPlain);
  ASSERT_TRUE(loop);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  (*loop)->stop();
  const double seconds = steady_seconds() - began;
  const TimingReport& report = (*loop)->report();
  EXPECT_EQ(report.ticks, report.safety.ticks);
  EXPECT_EQ(report.target_rate, 1000);
  // Deadlines are absolute: together with missed ones, each millisecond has its tick, except for a last late
  // one.
  EXPECT_NEAR(double(report.ticks + report.missed), 1000 * report.seconds, 3 + 1000 * report.period.largest);
  EXPECT_LE(report.seconds, seconds);
  EXPECT_NEAR(report.rate, double(report.ticks - 1) / report.seconds, 1e-6);
  EXPECT_LE(report.period.p50, report.period.p99);
  EXPECT_LE(report.period.p99, report.period.largest);
  EXPECT_GE(report.jitter.largest, report.period.largest - 1e-3 - 1e-12);
  EXPECT_GE(report.compute.p50, 0.99 * Slow::kWork);
  EXPECT_GE(report.latency.p50, 0.99 * Slow::kWork);
  EXPECT_GE(report.compute.largest, report.compute.p50);
}

/// Model that counts allocations and context switches on the loop's thread.
struct Watch {
  std::atomic<int> ticks = 0;
  std::atomic<long> allocated = 0, voluntary_switches = 0;
  std::size_t allocations_before = 0;
  long switches_before = 0;
  bool misbehave = false;
  std::mutex mutex;

  static long switches() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nvcsw;
  }
  static void tick(void* context, std::span<const ToolCommand>, double, std::span<ToolReading> readings) {
    Watch& watch = *static_cast<Watch*>(context);
    const long now = switches();
    if (watch.ticks == 500) watch.allocations_before = test::allocations, watch.switches_before = now;
    if (watch.ticks > 500) {
      watch.allocated = long(test::allocations - watch.allocations_before);
      watch.voluntary_switches =
          now - watch.switches_before - (watch.ticks - 500);  // one sleep per tick is expected
    }
    if (watch.misbehave) {
      ::operator delete(::operator new(8));  // a new expression might be optimized away
      std::this_thread::sleep_for(std::chrono::microseconds(1));
    }
    for (ToolReading& reading : readings) reading.force.z = std::sin(0.01 * watch.ticks);
    watch.ticks++;
  }
};

// A tick neither allocates memory nor blocks; a model that does both is detected.
TEST(LoopTiming, TickNeitherAllocatesNorBlocks) {
  for (const bool misbehave : {false, true}) {
    VirtualDevice left({}, light_grip(press), VirtualTime::kClock),
        right({}, light_grip(press), VirtualTime::kClock);
    ASSERT_TRUE(left.open());
    ASSERT_TRUE(right.open());
    Watch watch;
    watch.misbehave = misbehave;
    auto loop = Loop::start({{.device = &left, .safety = short_ramp()},
                             {.device = &right, .coupling = Coupling{}, .safety = short_ramp()}},
                            Watch::tick, &watch, {.rate = 2000, .priority = 0, .lock_memory = false});
    ASSERT_TRUE(loop);
    ASSERT_TRUE(wait_for([&] { return watch.ticks > 1600; }));  // longer than two report intervals
    (*loop)->stop();
    EXPECT_EQ(watch.allocated > 0, misbehave) << watch.allocated;
    EXPECT_EQ(watch.voluntary_switches > 50, misbehave)
        << watch.voluntary_switches;  // the system itself may cause a few
  }
}

/// Model with old contact data that makes one force jump and pushes along the motion of the hand.
struct Odd {
  std::atomic<int> ticks = 0;
  static void tick(void* context, std::span<const ToolCommand>, double, std::span<ToolReading> readings) {
    const int n = ++static_cast<Odd*>(context)->ticks;
    readings[0].age = 0.02;
    readings[0].force.x = n > 100 ? 3 : 0;
  }
};

// The report contains the age of contacts, force jumps and generated energy.
TEST(LoopTiming, ReportsAgeJumpsAndEnergy) {
  VirtualDevice device({}, light_grip([](double) { return HandTarget{}; }), VirtualTime::kClock);
  ASSERT_TRUE(device.open());
  Odd model;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Odd::tick, &model, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return model.ticks > 200; }));
  (*loop)->stop();
  const TimingReport& report = (*loop)->report();
  EXPECT_NEAR(report.age.p50, 0.02, 2e-4);
  EXPECT_NEAR(report.model_force_jump, 3, 1e-12);
  EXPECT_GT(report.force_jump, 1);
  EXPECT_LT(report.force_jump, 5);
  EXPECT_LT(report.lowest_energy, -1e-4);  // it pushed the hand with 3 N
  EXPECT_GT(report.safety.damped, 0u);
}

// A device that keeps its own time sets the rate; of several that wait for their tick, the slowest.
TEST(LoopTiming, RateIsThatOfDevices) {
  StillDevice plain, waiting(Pacing::kDevice), calling(Pacing::kCallback);
  EXPECT_EQ(loop_rate(std::vector<Hand>{{.device = &plain}}, 500), 500);
  EXPECT_EQ(loop_rate(std::vector<Hand>{{.device = &plain}, {.device = &waiting}}, 500), 1000);
  EXPECT_EQ(loop_rate(std::vector<Hand>{{.device = &waiting}, {.device = &calling}}, 500), 1000);
}

// A device that blocks until its own tick determines the rate.
TEST(LoopTiming, BlockingDeviceSetsRate) {
  StillDevice device(Pacing::kDevice);
  device.period_us = 3000;
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return wall.ticks > 50; }));
  (*loop)->stop();
  const TimingReport& report = (*loop)->report();
  EXPECT_LT(report.rate, 1000.0 / 3);
  EXPECT_EQ(report.missed, 0u);
}

// A device with its own thread runs the ticks in its callback.
TEST(LoopTiming, CallbackDeviceRunsTicks) {
  StillDevice device(Pacing::kCallback);
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.002;
  EXPECT_TRUE(wait_for([&] { return std::abs(device.last - 1) < 1e-9; }));
  EXPECT_NEAR(wall.ticks, device.exchanges, 2);
  EXPECT_TRUE((*loop)->running());
  (*loop)->stop();
  EXPECT_EQ(device.last, 0);
  EXPECT_TRUE(device.closed);
  EXPECT_LT((*loop)->report().latency.p50, 0.5e-3);
}

// The first of two devices with callbacks determines the rate, and both receive forces.
TEST(LoopTiming, FirstCallbackDeviceSetsRate) {
  StillDevice first(Pacing::kCallback), second(Pacing::kCallback);
  second.period_us = 700;
  Wall wall;
  auto loop =
      Loop::start({{.device = &first, .safety = short_ramp()}, {.device = &second, .safety = short_ramp()}},
                  Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] {
    return (*loop)->status(0).start == SoftStart::kFull && (*loop)->status(1).start == SoftStart::kFull;
  }));
  first.z = -0.002, second.z = -0.004;
  EXPECT_TRUE(wait_for([&] { return std::abs(first.last - 1) < 1e-9 && std::abs(second.last - 2) < 1e-9; }));
  first.close();  // its callbacks end, so the force of the other device becomes stale
  EXPECT_TRUE(wait_for([&] { return second.last == 0; }));
  // the loop's own clock continues with the other device
  EXPECT_TRUE(wait_for([&] { return (*loop)->status(0).lost && std::abs(second.last - 2) < 1e-9; }));
  EXPECT_TRUE((*loop)->running());
}

}  // namespace
}  // namespace turgor::haptics

#include "turgor/haptics/loop.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/allocations.hpp"
#include "tests/haptics/still_device.hpp"
#include "turgor/haptics/real_time.hpp"
#include "turgor/haptics/virtual_device.hpp"

namespace turgor::haptics {
namespace {

using contact::ToolCommand;
using contact::ToolReading;

/// Tests request no real-time priority; they must hold without it.
constexpr LoopParams kPlain{.rate = 1000, .priority = 0, .lock_memory = false};

SafetyParams short_ramp() { return {.force = 12, .ramp = 0.005}; }

bool wait_for(const std::function<bool()>& done, double seconds = 60) {
  const double end = steady_seconds() + seconds;
  while (!done() && steady_seconds() < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return done();
}

/// A wall at z = 0 with 500 N/m, for every tool.
struct Wall {
  std::atomic<int> ticks = 0;
  std::atomic<std::size_t> tools = 0;
  static void tick(void* context, std::span<const ToolCommand> commands, double,
                   std::span<ToolReading> readings) {
    Wall& wall = *static_cast<Wall*>(context);
    wall.tools = commands.size();
    for (std::size_t i = 0; i < commands.size(); i++)
      readings[i].force.z = 500 * std::max(0.0, -commands[i].pose.position.z);
    wall.ticks++;
  }
};

/// Target that moves from 5 mm above the wall to 5 mm below it within 0.2 s.
HandTarget press(double time) {
  return {.pose = {.position = {0, 0, 0.005 - 0.01 * std::min(1.0, 5 * time)}, .axes = {}}};
}

/// True if the hand is at rest at `hand` with the given force, and the tool is at `tool`.
bool is_at_rest(Loop& loop, double hand, double tool, double force) {
  const HandStatus& status = loop.status(0);
  return std::abs(status.input.velocity.z) < 1e-3 && std::abs(status.input.pose.position.z - hand) < 2e-4 &&
         std::abs(status.command.pose.position.z - tool) < 2e-4 &&
         std::abs(status.output.force.z - force) < 0.1;
}

// A hand that presses a wall stops moving where the forces of hand and wall balance.
TEST(Loop, HandRestsAtForceBalance) {
  VirtualDevice device({}, light_grip(press), VirtualTime::kClock);
  ASSERT_TRUE(device.open());
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  const double z = -0.005 * 300 / 800;  // 300 (−5 mm − z) = 500 z
  EXPECT_TRUE(wait_for([&] { return is_at_rest(**loop, z, z, -500 * z); }));
  EXPECT_TRUE((*loop)->running());
  (*loop)->stop();
  EXPECT_FALSE((*loop)->running());
  EXPECT_GT((*loop)->report().ticks, 10u);
}

// With coupling the hand rests against wall and coupling in series.
TEST(Loop, CoupledForceIsSpringsInSeries) {
  VirtualDevice device({}, light_grip(press), VirtualTime::kClock);
  ASSERT_TRUE(device.open());
  Wall wall;
  auto loop = Loop::start({{.device = &device, .coupling = Coupling{}, .safety = short_ramp()}}, Wall::tick,
                          &wall, kPlain);
  ASSERT_TRUE(loop);
  const double series = 500.0 * 1000 / 1500, z = -0.005 * 300 / (300 + series);
  EXPECT_TRUE(wait_for([&] { return is_at_rest(**loop, z, z * series / 500, -series * z); }));
}

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
TEST(Loop, RunsAtRequestedRate) {
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
TEST(Loop, TickNeitherAllocatesNorBlocks) {
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
TEST(Loop, ReportsAgeJumpsAndEnergy) {
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

// Two hands share each tick, and each has its own workspace.
TEST(Loop, TwoHandsShareTicks) {
  StillDevice left, right;
  left.z = -0.002, right.z = 0.001;
  Wall wall;
  Workspace lower{.origin = {0, 0, -0.004}};
  auto loop = Loop::start({{.device = &left, .safety = short_ramp()},
                           {.device = &right, .workspace = lower, .safety = short_ramp()}},
                          Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  // Both start inside the wall: no force until they have left it.
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(left.largest, 0);
  left.z = 0.01, right.z = 0.01;
  ASSERT_TRUE(wait_for([&] {
    return (*loop)->status(0).start == SoftStart::kFull && (*loop)->status(1).start == SoftStart::kFull;
  }));
  left.z = -0.002, right.z = 0.001;
  EXPECT_TRUE(wait_for([&] { return std::abs(left.last - 1) < 1e-9 && std::abs(right.last - 1.5) < 1e-9; }));
  EXPECT_EQ(wall.tools, 2u);
}

// A lost device gets zero force and is reported; the other hand continues.
TEST(Loop, LostDeviceLeavesOtherRunning) {
  StillDevice lost, other;
  Wall wall;
  auto loop =
      Loop::start({{.device = &lost, .safety = short_ramp()}, {.device = &other, .safety = short_ramp()}},
                  Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  lost.z = other.z = -0.002;
  ASSERT_TRUE(wait_for([&] { return lost.last > 0.9; }));
  lost.unplugged = true;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  lost.largest = 0;
  const int ticks = wall.ticks;
  ASSERT_TRUE(wait_for([&] { return wall.ticks > ticks + 20; }));
  EXPECT_EQ(lost.largest, 0);
  EXPECT_GT(other.last, 0.9);
  EXPECT_TRUE((*loop)->running());
  const std::vector<std::string> notes = (*loop)->notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("still was lost: its cable is out"), std::string::npos) << notes[0];
  other.unplugged = true;  // now all devices are lost, and the model goes on
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(1).lost; }));
  const int alone = wall.ticks;
  EXPECT_TRUE(wait_for([&] { return wall.ticks > alone + 20; }));
  EXPECT_TRUE((*loop)->running());
}

/// The device answers again, and its force is off.
bool is_waiting(Loop& loop) {
  const HandStatus& status = loop.status(0);
  return !status.lost && status.start == SoftStart::kWaiting;
}

// A device that is plugged in again while its hand is deep inside a body gets no force until the hand has
// left it, then a soft start.
TEST(Loop, ReturnedDeviceStartsSoftly) {
  StillDevice device;
  Wall wall;
  SafetyParams safety = short_ramp();
  safety.ramp = 0.2;
  auto loop =
      Loop::start({{.device = &device, .coupling = Coupling{}, .safety = safety}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.002;
  ASSERT_TRUE(wait_for([&] { return device.last > 0.6; }));
  // without an answer for 200 ms; the hand moves meanwhile, by less than a jump
  device.unplugged = true;
  device.z = -0.02;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  EXPECT_EQ((*loop)->news().size(), 1u);  // its reason is known only while it is lost
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  device.largest = 0;
  device.unplugged = false;
  ASSERT_TRUE(wait_for([&] { return is_waiting(**loop); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(device.largest, 0) << "N, inside the wall";
  EXPECT_NEAR((*loop)->status(0).command.pose.position.z, -0.02 * 1000 / 1500, 1e-4)
      << "m: the proxy rests between coupling and wall";
  // outside, then a press
  device.z = 0.01;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.002;
  const double series = 500.0 * 1000 / 1500;
  EXPECT_TRUE(wait_for([&] { return std::abs(device.last - 0.002 * series) < 1e-6; })) << device.last;
  (*loop)->stop();
  EXPECT_LE((*loop)->report().force_jump, 12 * 2 * 1e-3 / 0.005 * 1.0001);
  const std::vector<std::string> notes = (*loop)->notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("still was lost: its cable is out; it returned"), std::string::npos) << notes[0];
}

// The tool of a device that has not answered yet is in the middle of its workspace.
TEST(Loop, SilentDeviceLeavesToolInMiddle) {
  StillDevice device;
  device.unplugged = true;
  Wall wall;
  const Workspace workspace{.origin = {0.1, 0.2, 0.3}};
  auto loop = Loop::start({{.device = &device, .workspace = workspace}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  EXPECT_EQ((*loop)->status(0).command.pose.position, workspace.origin);
}

// The reason of a loss is known after stop, which closes the device.
TEST(Loop, LossIsReportedAfterStop) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  device.unplugged = true;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).lost; }));
  (*loop)->stop();
  device.unplugged = false;  // a closed device states another reason
  const std::vector<std::string> notes = (*loop)->notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("still was lost: its cable is out"), std::string::npos) << notes[0];
}

// Ticks go on after a device that called them has ended its calls, and its loss is reported.
TEST(Loop, EndedCallsAreALoss) {
  for (const int pause : {130, 400}) {  // until stop: before and after the ticks notice [ms]
    StillDevice device(Pacing::kCallback);
    Wall wall;
    auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
    ASSERT_TRUE(loop);
    ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
    device.unplugged = true;
    device.close();
    const int ticks = wall.ticks;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause));
    if (pause > 200) {
      EXPECT_TRUE(wait_for([&] { return wall.ticks > ticks + 50; }));
    }
    (*loop)->stop();
    const std::vector<std::string> notes = (*loop)->notes(), news = (*loop)->news();
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("still was lost: its cable is out; its forces are off"), std::string::npos)
        << notes[0];
    EXPECT_EQ(news.size(), 1u);
  }
}

// A device that keeps its own time sets the rate; of several that wait for their tick, the slowest.
TEST(Loop, RateIsThatOfDevices) {
  StillDevice plain, waiting(Pacing::kDevice), calling(Pacing::kCallback);
  EXPECT_EQ(loop_rate(std::vector<Hand>{{.device = &plain}}, 500), 500);
  EXPECT_EQ(loop_rate(std::vector<Hand>{{.device = &plain}, {.device = &waiting}}, 500), 1000);
  EXPECT_EQ(loop_rate(std::vector<Hand>{{.device = &waiting}, {.device = &calling}}, 500), 1000);
}

// Stopping fades the force, ends the thread and closes the devices.
TEST(Loop, StopFadesForceAndCloses) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.02;
  ASSERT_TRUE(wait_for([&] { return device.last > 9.9; }));
  (*loop)->stop();
  EXPECT_EQ(device.last, 0);
  EXPECT_TRUE(device.closed);
  const int ticks = wall.ticks;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(wall.ticks, ticks);
  EXPECT_LE((*loop)->report().force_jump,
            12 * 2 * 1e-3 / 0.005 * 1.0001);  // no step exceeds the slew rate
  (*loop)->stop();
}

// A model that throws stops the forces but not the program.
TEST(Loop, ThrowingModelStopsForces) {
  StillDevice device;
  struct Thrower {
    std::atomic<int> ticks = 0;
    static void tick(void* context, std::span<const ToolCommand>, double, std::span<ToolReading> readings) {
      readings[0].force.z = 1;
      if (++static_cast<Thrower*>(context)->ticks > 50) throw std::runtime_error("no convergence");
    }
  } model;
  auto loop = Loop::start({{.device = &device, .safety = {.small_force = 2, .ramp = 0.005}}}, Thrower::tick,
                          &model, kPlain);
  ASSERT_TRUE(loop);
  EXPECT_TRUE(wait_for([&] { return !(*loop)->running(); }));
  EXPECT_TRUE(wait_for([&] { return device.last == 0; }));
  EXPECT_EQ((*loop)->notes().size(), 1u);
  EXPECT_EQ(device.largest, 1);
}

// A device that blocks until its own tick determines the rate.
TEST(Loop, BlockingDeviceSetsRate) {
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
TEST(Loop, CallbackDeviceRunsTicks) {
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
TEST(Loop, FirstCallbackDeviceSetsRate) {
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

// The pressed clutch detaches the tool from the hand and sends zero force.
TEST(Loop, ClutchDetachesToolAndForce) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device, .safety = short_ramp()}}, Wall::tick, &wall, kPlain);
  ASSERT_TRUE(loop);
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).start == SoftStart::kFull; }));
  device.z = -0.002;
  ASSERT_TRUE(wait_for([&] { return device.last > 0.9; }));
  device.buttons = Buttons{}.clutch;
  ASSERT_TRUE(wait_for([&] { return device.last == 0; }));
  device.z = 0.03;
  ASSERT_TRUE(wait_for([&] { return (*loop)->status(0).input.pose.position.z == 0.03; }));
  EXPECT_NEAR((*loop)->status(0).command.pose.position.z, -0.002, 1e-12);
}

// A loop without devices, or with a rate of zero, is an error.
TEST(Loop, InvalidParametersAreErrors) {
  Wall wall;
  const auto none = Loop::start({}, Wall::tick, &wall);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("expected a device"), std::string::npos);
  StillDevice device;
  const auto slow = Loop::start({{.device = &device}}, Wall::tick, &wall, {.rate = 0});
  ASSERT_FALSE(slow);
  EXPECT_NE(slow.error().message.find("found 0"), std::string::npos);
}

// A real-time priority that the system denies gives a note and no error.
TEST(Loop, MissingPrivilegesAreNotes) {
  StillDevice device;
  Wall wall;
  auto loop = Loop::start({{.device = &device}}, Wall::tick, &wall,
                          {.rate = 1000, .priority = 80, .lock_memory = false});
  ASSERT_TRUE(loop);
  EXPECT_TRUE(wait_for([&] { return wall.ticks > 10; }));
  for (const std::string& note : (*loop)->notes()) EXPECT_NE(note.find("ulimit"), std::string::npos) << note;
}

}  // namespace
}  // namespace turgor::haptics

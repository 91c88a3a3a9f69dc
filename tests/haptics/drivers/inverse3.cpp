#include "turgor/haptics/drivers/inverse3.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <thread>

#include "tests/allocations.hpp"
#include "tests/haptics/drivers/inverse_service.hpp"
#include "tests/refused.hpp"
#include "turgor/core/timing.hpp"

namespace turgor::haptics {
namespace {

using test::Behavior;
using test::InverseService;

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// A driver and the service that it connects to.
class Inverse3Driver : public testing::Test {
 protected:
  Status open(DeviceOptions options = {}) {
    options.address = service->address();
    device = std::make_unique<Inverse3>(options);
    return device->open();
  }
  /// Exchanges once per millisecond, like a haptic loop, until `goal` is met. Returns false after a minute.
  template <class F>
  bool exchange_until(Vec3d force, const F& goal) {
    for (const Timer time; time.seconds() < 60; sleep_ms(1)) {
      exchanged = device->exchange({.force = force}, input);
      if (goal()) return true;
    }
    return false;
  }
  bool trouble_has(const std::string& words) { return device->trouble().find(words) != std::string::npos; }

  std::optional<InverseService> service{std::in_place};
  std::unique_ptr<Inverse3> device;
  DeviceInput input;
  bool exchanged = false;
};
// The force is sent with either key that the versions of the service use.
TEST_F(Inverse3Driver, ForceWorksWithBothKeys) {
  for (const char* key : {"vector", "values"}) {
    service.emplace(key);
    ASSERT_TRUE(open());
    EXPECT_TRUE(exchange_until({1, -2, 0.5}, [&] { return service->force() == Vec3d{1, -2, 0.5}; })) << key;
    device->close();
  }
}

// Position and velocity of the hand are read.
TEST_F(Inverse3Driver, ReadsHandMotion) {
  service->set_hand({0.02, -0.03, 0.04}, {0.1, 0.2, -0.3});
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return exchanged; }));
  EXPECT_EQ(input.pose.position, (Vec3d{0.02, -0.03, 0.04}));
  EXPECT_EQ(input.velocity, (Vec3d{0.1, 0.2, -0.3}));
  EXPECT_EQ(device->trouble(), "");
}

// Each command waits for the answer to the previous one.
TEST_F(Inverse3Driver, CommandsWaitForAnswers) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return service->received().size() > 200; }));
  EXPECT_EQ(service->unanswered(), 0);
}

// Only the first command contains the configuration.
TEST_F(Inverse3Driver, OnlyFirstCommandConfigures) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return service->received().size() > 20; }));
  const std::vector<nlohmann::json> received = service->received();
  EXPECT_EQ(received[0]["session"]["configure"]["basis"]["permutation"], "XYZ");
  EXPECT_EQ(received[0]["inverse3"][0]["configure"]["preset"]["preset"], "arm_front_centered");
  for (std::size_t n = 1; n < received.size(); n++) {
    EXPECT_FALSE(received[n].contains("session")) << n;
    EXPECT_FALSE(received[n]["inverse3"][0].contains("configure")) << n;
    EXPECT_EQ(received[n]["inverse3"][0]["device_id"], "049D");
  }
}

// A grip gives orientation and buttons; buttons are numbered in alphabetical order.
TEST_F(Inverse3Driver, ReadsGripOrientationAndButtons) {
  const double half = std::sqrt(0.5);  // a quarter turn about z
  service->set_grip("wireless_verse_grip", {{"orientation", {{"w", half}, {"x", 0}, {"y", 0}, {"z", half}}},
                                            {"buttons", {{"c", true}, {"a", true}, {"b", false}}}});
  ASSERT_TRUE(open());
  EXPECT_TRUE(device->spec().has_orientation);
  ASSERT_TRUE(exchange_until({}, [&] { return exchanged; }));
  EXPECT_NEAR(norm(input.pose.axes.column[1] - Vec3d{-1, 0, 0}), 0, 1e-12);
  EXPECT_EQ(input.buttons, 5u);
  EXPECT_EQ(norm(input.angular_velocity), 0);
  service->set_grip(
      "verse_grip",
      {{"orientation", {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}}, {"button", true}, {"hall", 0}});
  EXPECT_TRUE(exchange_until({}, [&] { return input.buttons == 1; }));
  EXPECT_NEAR(norm(input.pose.axes.column[1] - Vec3d{0, 1, 0}), 0, 1e-12);
}

// The angular velocity of a grip is estimated from its orientations.
TEST_F(Inverse3Driver, EstimatesAngularVelocity) {
  service->set_grip("verse_grip", {{"orientation", {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}}});
  ASSERT_TRUE(open());
  // 10 rad/s about x, for 0.3 s
  std::vector<double> speeds;
  for (const Timer time; time.seconds() < 0.3; sleep_ms(1)) {
    const double angle = 10 * time.seconds();
    service->set_grip("verse_grip",
                      {{"orientation", {{"w", std::cos(angle / 2)}, {"x", std::sin(angle / 2)}}}});
    if (device->exchange({}, input) && time.seconds() > 0.1) speeds.push_back(input.angular_velocity.x);
  }
  EXPECT_NEAR(median(speeds), 10, 2);
}

// The force is limited; one that is not finite is sent as zero.
TEST_F(Inverse3Driver, LimitsForce) {
  ASSERT_TRUE(open());
  EXPECT_TRUE(exchange_until({30, 0, -40}, [&] { return norm(service->force() - Vec3d{3, 0, -4}) < 1e-9; }));
  const double nan = std::nan("");
  EXPECT_TRUE(exchange_until({nan, 0, 1}, [&] { return norm(service->force()) == 0; }));
}

// The force becomes zero when the haptic thread stalls.
TEST_F(Inverse3Driver, StaleForceBecomesZero) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({2, 0, 0}, [&] { return service->force().x == 2; }));
  sleep_ms(200);
  EXPECT_EQ(norm(service->force()), 0);
}

// Closing sends zero force first; the device can be opened again.
TEST_F(Inverse3Driver, CloseSendsZeroForce) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({2, 0, 0}, [&] { return service->force().x == 2; }));
  device->close();
  EXPECT_EQ(norm(service->force()), 0);
  const nlohmann::json last = service->received().back();
  EXPECT_EQ(last["inverse3"][0]["commands"]["set_cursor_force"]["vector"]["x"], 0);
  EXPECT_FALSE(device->exchange({}, input));
  EXPECT_TRUE(trouble_has("not open"));
  device->close();
  ASSERT_TRUE(device->open());
  EXPECT_TRUE(exchange_until({}, [&] { return exchanged; }));
}

// Invalid answers are discarded with a message; the next valid one is used.
TEST_F(Inverse3Driver, InvalidAnswersAreDiscarded) {
  service->set_hand({0.01, 0, 0}, {});
  ASSERT_TRUE(open());
  for (const Behavior behavior :
       {Behavior::kGarbage, Behavior::kNoNumber, Behavior::kHuge, Behavior::kOtherTypes}) {
    ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return exchanged && device->trouble().empty(); }))
        << int(behavior);
    service->set_behavior(behavior);
    const std::string words =
        behavior == Behavior::kHuge ? "implausible position or speed" : "sent an invalid message";
    // on a slow machine the answer is late first
    EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !exchanged && trouble_has(words); }))
        << int(behavior) << ": " << device->trouble();
    EXPECT_EQ(input.pose.position, (Vec3d{0.01, 0, 0}));  // unchanged
    EXPECT_FALSE(device->exchange({}, input)) << int(behavior);
    service->set_behavior(Behavior::kGood);
  }
}

// Fields that are missing in an answer keep their last values.
TEST_F(Inverse3Driver, MissingFieldsKeepOldValues) {
  service->set_hand({0.01, 0.02, 0.03}, {0.5, 0, 0});
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return exchanged && input.velocity.x == 0.5; }));
  service->set_behavior(Behavior::kOmitting);  // omits the status too: the arm stays calibrated
  EXPECT_TRUE(exchange_until({}, [&] { return exchanged && input.velocity.x == 0; }));
  EXPECT_EQ(input.pose.position, (Vec3d{0.01, 0.02, 0.03}));
}

// Late answers are discarded, and an exchange never blocks on them.
TEST_F(Inverse3Driver, LateAnswersAreDiscarded) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return exchanged; }));
  service->set_behavior(Behavior::kLate);
  std::vector<double> durations;
  int lost = 0;
  for (int n = 0; n < 400; n++, sleep_ms(1)) {
    const Timer time;
    if (!device->exchange({.force = {1, 0, 0}}, input)) lost++;
    durations.push_back(time.seconds());
  }
  EXPECT_GT(lost, 100);  // answers arrive every 60 ms and are valid for 20 ms
  EXPECT_LT(percentile(durations, 0.95), 1e-3);
  service->set_behavior(Behavior::kGood);
  EXPECT_TRUE(exchange_until({}, [&] { return exchanged; }));
}

// A service that stops answering is reported and reconnected.
TEST_F(Inverse3Driver, SilentServiceIsReconnected) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return exchanged; }));
  service->set_behavior(Behavior::kSilent);
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !exchanged; }));
  EXPECT_TRUE(trouble_has("has not answered for")) << device->trouble();
  EXPECT_TRUE(exchange_until({}, [&] { return trouble_has("no answer for 1 s"); })) << device->trouble();
  service->set_behavior(Behavior::kGood);
  EXPECT_TRUE(exchange_until({}, [&] { return exchanged; })) << device->trouble();
  EXPECT_EQ(service->connections(), 2);
}

// A broken connection is reported and established again.
TEST_F(Inverse3Driver, BrokenConnectionIsReconnected) {
  ASSERT_TRUE(open());
  for (const Behavior behavior : {Behavior::kHangsUp, Behavior::kBrokenText}) {
    ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return exchanged; })) << device->trouble();
    service->set_behavior(behavior);
    EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !exchanged && trouble_has(service->address()); }))
        << int(behavior);
    service->set_behavior(Behavior::kGood);
  }
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return exchanged; })) << device->trouble();
  service.reset();  // the whole service ends
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !exchanged && trouble_has("install and start"); }))
      << device->trouble();
}

// An arm gets no force until it is calibrated.
TEST_F(Inverse3Driver, UncalibratedArmGetsNoForce) {
  service->set_calibrated(false);
  ASSERT_TRUE(open());
  exchange_until({2, 0, 0}, [&] { return service->received().size() > 50; });
  EXPECT_FALSE(exchanged);
  EXPECT_TRUE(trouble_has("049D is not calibrated")) << device->trouble();
  EXPECT_EQ(norm(service->force()), 0);
  service->set_calibrated(true);
  EXPECT_TRUE(exchange_until({2, 0, 0}, [&] { return exchanged && service->force().x == 2; }));
}

// Opening polls once per second for an arm until the patience ends.
TEST_F(Inverse3Driver, OpenPollsForArmEverySecond) {
  service->set_arms({});
  const Timer time;
  EXPECT_REFUSED(open({.patience = 1.5}), "reports no arm", "asked 2 times in 1.5 s");
  EXPECT_NEAR(time.seconds(), 1.5, 0.7);
  const std::vector<nlohmann::json> received = service->received();
  ASSERT_EQ(received.size(), 2u);
  for (const nlohmann::json& message : received)
    EXPECT_TRUE(message["session"].contains("force_render_full_state"));
}

// A service that sends invalid messages is distinguished from one without arms.
TEST_F(Inverse3Driver, ForeignServiceIsReported) {
  service->set_behavior(Behavior::kOtherTypes);
  EXPECT_REFUSED(open({.patience = 0}), "sent an invalid message");
  service->set_behavior(Behavior::kGarbage);
  EXPECT_REFUSED(open({.patience = 0}), "sent an invalid message");
}

// An arm that is connected while opening waits is found.
TEST_F(Inverse3Driver, OpenFindsArmConnectedLater) {
  service->set_arms({});
  std::thread hand([this] {
    sleep_ms(300);
    service->set_arms({"04EA"});
  });
  const Status opened = open({.patience = 10});
  hand.join();
  ASSERT_TRUE(opened);
  EXPECT_EQ(device->spec().name, "Haply inverse3 04EA");
}

// An unplugged arm is reported and found again after reconnection.
TEST_F(Inverse3Driver, UnpluggedArmIsFoundAgain) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return exchanged; }));
  service->set_arms({});
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !exchanged && trouble_has("reports no arm"); }));
  service->set_arms({"049D"});
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return exchanged && service->force().x == 1; }))
      << device->trouble();
}

// One of several arms must be selected by its identifier.
TEST_F(Inverse3Driver, SeveralArmsNeedSelection) {
  service->set_arms({"049D", "MINI"});
  EXPECT_REFUSED(open(), "049D, MINI", "choose one");
  EXPECT_REFUSED(open({.which = "0000", .patience = 0}), "049D, MINI", "0000");
  ASSERT_TRUE(open({.which = "MINI"}));
  EXPECT_EQ(device->spec().name, "Haply minverse MINI");
  EXPECT_EQ(device->spec().workspace_high.x, 0.04);
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return service->force().x == 1; }));
  EXPECT_EQ(service->received().back()["inverse3"][0]["device_id"], "MINI");
}

// An exchange allocates no memory, even if answers are invalid or the connection breaks.
TEST_F(Inverse3Driver, ExchangeAllocatesNothing) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return exchanged; }));
  for (const Behavior behavior : {Behavior::kGood, Behavior::kGarbage, Behavior::kHangsUp}) {
    service->set_behavior(behavior);
    const std::size_t before = test::allocations;
    for (int n = 0; n < 50; n++, sleep_ms(1)) device->exchange({.force = {1, 0, 0}}, input);
    EXPECT_EQ(test::allocations, before) << int(behavior);
  }
}

// Without a service the error states at once what to install: within two seconds, in the fastest of some
// tries, since others may use the machine.
TEST(Inverse3, MissingServiceIsExplained) {
  double fastest = 60;  // [s]
  for (int n = 0; n < 5 && fastest >= 2; n++) {
    const Timer time;
    EXPECT_REFUSED(Inverse3({.address = "127.0.0.1:1"}).open(), "127.0.0.1:1", "Haply Inverse Service",
                   "docs/devices.md");
    EXPECT_REFUSED(Inverse3({.address = "nonsense"}).open(), "HOST:PORT", "nonsense");
    fastest = std::min(fastest, time.seconds());
  }
  EXPECT_LT(fastest, 2);
}

}  // namespace
}  // namespace turgor::haptics

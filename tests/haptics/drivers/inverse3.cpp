#include "turgor/haptics/drivers/inverse3.hpp"

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

using test::InverseService;
using test::Manner;

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// A driver and the service that it talks to.
class Inverse3Driver : public testing::Test {
 protected:
  Status open(DeviceOptions options = {}) {
    options.address = service->address();
    device = std::make_unique<Inverse3>(options);
    return device->open();
  }
  /// Exchanges once a millisecond, as a haptic loop does, until `goal` is met; whether it was within 5 s.
  template <class F>
  bool exchange_until(Vec3d force, const F& goal) {
    for (const Timer time; time.seconds() < 5; sleep_ms(1)) {
      was_felt = device->exchange({.force = force}, input);
      if (goal()) return true;
    }
    return false;
  }
  bool trouble_has(const std::string& words) { return device->trouble().find(words) != std::string::npos; }

  std::optional<InverseService> service{std::in_place};
  std::unique_ptr<Inverse3> device;
  DeviceInput input;
  bool was_felt = false;
};
TEST_F(Inverse3Driver, a_force_is_felt_in_either_spelling_of_the_service) {
  for (const char* key : {"vector", "values"}) {
    service.emplace(key);
    ASSERT_TRUE(open());
    EXPECT_TRUE(exchange_until({1, -2, 0.5}, [&] { return service->force() == Vec3d{1, -2, 0.5}; })) << key;
    device->close();
  }
}

TEST_F(Inverse3Driver, what_the_hand_does_is_read) {
  service->set_hand({0.02, -0.03, 0.04}, {0.1, 0.2, -0.3});
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return was_felt; }));
  EXPECT_EQ(input.pose.position, (Vec3d{0.02, -0.03, 0.04}));
  EXPECT_EQ(input.velocity, (Vec3d{0.1, 0.2, -0.3}));
  EXPECT_EQ(device->trouble(), "");
}

TEST_F(Inverse3Driver, every_command_waits_for_the_answer_to_the_one_before) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return service->heard().size() > 200; }));
  EXPECT_EQ(service->unanswered(), 0);
}

TEST_F(Inverse3Driver, configuration_is_in_the_first_command_alone) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return service->heard().size() > 20; }));
  const std::vector<nlohmann::json> heard = service->heard();
  EXPECT_EQ(heard[0]["session"]["configure"]["basis"]["permutation"], "XYZ");
  EXPECT_EQ(heard[0]["inverse3"][0]["configure"]["preset"]["preset"], "arm_front_centered");
  for (std::size_t n = 1; n < heard.size(); n++) {
    EXPECT_FALSE(heard[n].contains("session")) << n;
    EXPECT_FALSE(heard[n]["inverse3"][0].contains("configure")) << n;
    EXPECT_EQ(heard[n]["inverse3"][0]["device_id"], "049D");
  }
}

TEST_F(Inverse3Driver, a_grip_turns_and_has_buttons_in_alphabetical_order) {
  const double half = std::sqrt(0.5);  // a quarter turn about z
  service->set_grip("wireless_verse_grip", {{"orientation", {{"w", half}, {"x", 0}, {"y", 0}, {"z", half}}},
                                            {"buttons", {{"c", true}, {"a", true}, {"b", false}}}});
  ASSERT_TRUE(open());
  EXPECT_TRUE(device->spec().has_orientation);
  ASSERT_TRUE(exchange_until({}, [&] { return was_felt; }));
  EXPECT_NEAR(norm(input.pose.axes.column[1] - Vec3d{-1, 0, 0}), 0, 1e-12);
  EXPECT_EQ(input.buttons, 5u);
  EXPECT_EQ(norm(input.angular_velocity), 0);
  service->set_grip(
      "verse_grip",
      {{"orientation", {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}}, {"button", true}, {"hall", 0}});
  EXPECT_TRUE(exchange_until({}, [&] { return input.buttons == 1; }));
  EXPECT_NEAR(norm(input.pose.axes.column[1] - Vec3d{0, 1, 0}), 0, 1e-12);
}

TEST_F(Inverse3Driver, how_fast_a_grip_turns_is_measured) {
  service->set_grip("verse_grip", {{"orientation", {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}}});
  ASSERT_TRUE(open());
  // 10 rad/s about x, for 0.3 s.
  std::vector<double> speeds;
  for (const Timer time; time.seconds() < 0.3; sleep_ms(1)) {
    const double angle = 10 * time.seconds();
    service->set_grip("verse_grip",
                      {{"orientation", {{"w", std::cos(angle / 2)}, {"x", std::sin(angle / 2)}}}});
    if (device->exchange({}, input) && time.seconds() > 0.1) speeds.push_back(input.angular_velocity.x);
  }
  EXPECT_NEAR(median(speeds), 10, 2);
}

TEST_F(Inverse3Driver, limits_are_kept_and_a_force_that_is_no_number_is_not_sent) {
  ASSERT_TRUE(open());
  EXPECT_TRUE(exchange_until({30, 0, -40}, [&] { return norm(service->force() - Vec3d{3, 0, -4}) < 1e-9; }));
  const double nan = std::nan("");
  EXPECT_TRUE(exchange_until({nan, 0, 1}, [&] { return norm(service->force()) == 0; }));
}

TEST_F(Inverse3Driver, a_force_is_forgotten_when_the_haptic_thread_stands_still) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({2, 0, 0}, [&] { return service->force().x == 2; }));
  sleep_ms(200);
  EXPECT_EQ(norm(service->force()), 0);
}

TEST_F(Inverse3Driver, closing_lets_go_first) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({2, 0, 0}, [&] { return service->force().x == 2; }));
  device->close();
  EXPECT_EQ(norm(service->force()), 0);
  const nlohmann::json last = service->heard().back();
  EXPECT_EQ(last["inverse3"][0]["commands"]["set_cursor_force"]["vector"]["x"], 0);
  EXPECT_FALSE(device->exchange({}, input));
  EXPECT_TRUE(trouble_has("not open"));
  device->close();
  ASSERT_TRUE(device->open());
  EXPECT_TRUE(exchange_until({}, [&] { return was_felt; }));
}

TEST_F(Inverse3Driver, answers_that_make_no_sense_are_not_used_and_the_next_good_one_is) {
  service->set_hand({0.01, 0, 0}, {});
  ASSERT_TRUE(open());
  for (const Manner manner : {Manner::kGarbage, Manner::kNoNumber, Manner::kHuge, Manner::kOtherTypes}) {
    ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return was_felt && device->trouble().empty(); }))
        << int(manner);
    service->set_manner(manner);
    EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !was_felt; })) << int(manner);
    EXPECT_TRUE(trouble_has(manner == Manner::kHuge ? "cannot be" : "makes no sense")) << device->trouble();
    EXPECT_EQ(input.pose.position, (Vec3d{0.01, 0, 0}));  // as it was
    EXPECT_FALSE(device->exchange({}, input)) << int(manner);
    service->set_manner(Manner::kGood);
  }
}

TEST_F(Inverse3Driver, what_an_answer_leaves_out_stays_as_it_was) {
  service->set_hand({0.01, 0.02, 0.03}, {0.5, 0, 0});
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return was_felt && input.velocity.x == 0.5; }));
  service->set_manner(Manner::kOmitting);  // status too: it stays calibrated
  EXPECT_TRUE(exchange_until({}, [&] { return was_felt && input.velocity.x == 0; }));
  EXPECT_EQ(input.pose.position, (Vec3d{0.01, 0.02, 0.03}));
}

TEST_F(Inverse3Driver, late_answers_are_not_used_and_nobody_waits_for_them) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return was_felt; }));
  service->set_manner(Manner::kLate);
  std::vector<double> took;
  int lost = 0;
  for (int n = 0; n < 400; n++, sleep_ms(1)) {
    const Timer time;
    if (!device->exchange({.force = {1, 0, 0}}, input)) lost++;
    took.push_back(time.seconds());
  }
  EXPECT_GT(lost, 100);  // of answers that come each 60 ms and are good for 20
  EXPECT_LT(percentile(took, 0.95), 1e-3);
  service->set_manner(Manner::kGood);
  EXPECT_TRUE(exchange_until({}, [&] { return was_felt; }));
}

TEST_F(Inverse3Driver, a_service_that_falls_silent_is_told_and_asked_anew) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return was_felt; }));
  service->set_manner(Manner::kSilent);
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !was_felt; }));
  EXPECT_TRUE(trouble_has("has not answered for")) << device->trouble();
  EXPECT_TRUE(exchange_until({}, [&] { return trouble_has("no answer for 1 s"); })) << device->trouble();
  service->set_manner(Manner::kGood);
  EXPECT_TRUE(exchange_until({}, [&] { return was_felt; })) << device->trouble();
  EXPECT_EQ(service->connections(), 2);
}

TEST_F(Inverse3Driver, a_connection_that_breaks_is_told_and_made_again) {
  ASSERT_TRUE(open());
  for (const Manner manner : {Manner::kHangsUp, Manner::kBrokenText}) {
    ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return was_felt; })) << device->trouble();
    service->set_manner(manner);
    EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !was_felt && trouble_has(service->address()); }))
        << int(manner);
    service->set_manner(Manner::kGood);
  }
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return was_felt; })) << device->trouble();
  service.reset();  // the whole service ends
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !was_felt && trouble_has("install and start"); }))
      << device->trouble();
}

TEST_F(Inverse3Driver, an_arm_that_is_not_calibrated_gets_no_force_until_it_is) {
  service->set_calibrated(false);
  ASSERT_TRUE(open());
  exchange_until({2, 0, 0}, [&] { return service->heard().size() > 50; });
  EXPECT_FALSE(was_felt);
  EXPECT_TRUE(trouble_has("049D is not calibrated")) << device->trouble();
  EXPECT_EQ(norm(service->force()), 0);
  service->set_calibrated(true);
  EXPECT_TRUE(exchange_until({2, 0, 0}, [&] { return was_felt && service->force().x == 2; }));
}

TEST_F(Inverse3Driver, an_arm_that_is_not_there_is_asked_for_once_a_second) {
  service->set_arms({});
  const Timer time;
  EXPECT_REFUSED(open({.patience = 1.5}), "knows no arm", "asked 2 times in 1.5 s");
  EXPECT_NEAR(time.seconds(), 1.5, 0.7);
  const std::vector<nlohmann::json> heard = service->heard();
  ASSERT_EQ(heard.size(), 2u);
  for (const nlohmann::json& message : heard)
    EXPECT_TRUE(message["session"].contains("force_render_full_state"));
}

TEST_F(Inverse3Driver, a_service_of_another_kind_is_told_from_one_without_arms) {
  service->set_manner(Manner::kOtherTypes);
  EXPECT_REFUSED(open({.patience = 0}), "makes no sense");
  service->set_manner(Manner::kGarbage);
  EXPECT_REFUSED(open({.patience = 0}), "makes no sense");
}

TEST_F(Inverse3Driver, an_arm_that_is_connected_while_it_is_waited_for_is_found) {
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

TEST_F(Inverse3Driver, an_arm_that_is_unplugged_is_told_and_found_again) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return was_felt; }));
  service->set_arms({});
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return !was_felt && trouble_has("knows no arm"); }));
  service->set_arms({"049D"});
  EXPECT_TRUE(exchange_until({1, 0, 0}, [&] { return was_felt && service->force().x == 1; }))
      << device->trouble();
}

TEST_F(Inverse3Driver, of_two_arms_one_is_named) {
  service->set_arms({"049D", "MINI"});
  EXPECT_REFUSED(open(), "049D, MINI", "say which");
  EXPECT_REFUSED(open({.which = "0000", .patience = 0}), "049D, MINI", "0000");
  ASSERT_TRUE(open({.which = "MINI"}));
  EXPECT_EQ(device->spec().name, "Haply minverse MINI");
  EXPECT_EQ(device->spec().workspace_high.x, 0.04);
  ASSERT_TRUE(exchange_until({1, 0, 0}, [&] { return service->force().x == 1; }));
  EXPECT_EQ(service->heard().back()["inverse3"][0]["device_id"], "MINI");
}

TEST_F(Inverse3Driver, an_exchange_allocates_nothing) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(exchange_until({}, [&] { return was_felt; }));
  for (const Manner manner : {Manner::kGood, Manner::kGarbage, Manner::kHangsUp}) {
    service->set_manner(manner);
    const std::size_t before = test::allocations;
    for (int n = 0; n < 50; n++, sleep_ms(1)) device->exchange({.force = {1, 0, 0}}, input);
    EXPECT_EQ(test::allocations, before) << int(manner);
  }
}

TEST(Inverse3, without_a_service_it_says_what_to_install_at_once) {
  const Timer time;
  EXPECT_REFUSED(Inverse3({.address = "127.0.0.1:1"}).open(), "127.0.0.1:1", "Haply Inverse Service",
                 "docs/devices.md");
  EXPECT_REFUSED(Inverse3({.address = "nonsense"}).open(), "HOST:PORT", "nonsense");
  EXPECT_LT(time.seconds(), 2);
}

}  // namespace
}  // namespace turgor::haptics

// `turgor devices` as people see it.
#include "tests/app/program.hpp"
#include "turgor/core/timing.hpp"

namespace turgor {
namespace {

using namespace test;

TEST(DevicesCommand, tells_of_every_driver_in_two_seconds_what_it_needs) {
  const fs::path folder = fresh_folder();
  const Timer time;
  const Ended ended =
      run_program("devices --address 127.0.0.1:1 --json devices.json", folder, "unset FDSDK FORCEDIM_SDK");
  EXPECT_LT(time.seconds(), 2);
  EXPECT_EQ(ended.code, 0) << ended.printed;
  const nlohmann::json found = read_json(folder / "devices.json");
  ASSERT_GE(found["drivers"].size(), 4u);
  for (const nlohmann::json& driver : found["drivers"]) {
    EXPECT_NE(ended.printed.find(driver["driver"].get<std::string>()), std::string::npos);
    EXPECT_NE(ended.printed.find(driver["note"].get<std::string>()), std::string::npos);
    EXPECT_NE(driver["note"], "");
  }
  EXPECT_NE(ended.printed.find("install and start the Haply Inverse Service"), std::string::npos);
}

TEST(DevicesCommand, refuses_a_goal_that_cannot_be_written) {
  const Ended ended = run_program("devices --json nowhere/devices.json", fresh_folder());
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("nowhere"), std::string::npos) << ended.printed;
}

}  // namespace
}  // namespace turgor

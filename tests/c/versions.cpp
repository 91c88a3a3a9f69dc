// Callers that were compiled with an older or a newer header.
#include <array>
#include <cstddef>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/owned_world.hpp"

namespace turgor {
namespace {

using test::def_of;
using test::finger_at;
using test::kPad;
using test::OwnedWorld;

// Structs of an older, shorter header are accepted, and nothing is written beyond their size.
TEST(CVersions, AcceptsOlderStructs) {
  tg_world_def def = def_of(kPad);
  def.size = offsetof(tg_world_def, folder);  // the size of an older struct
  std::memset(reinterpret_cast<char*>(&def) + def.size, 0x7f, sizeof def - def.size);
  const OwnedWorld c(def);
  tg_world_info info;
  std::memset(static_cast<void*>(&info), 0x7f, sizeof info);
  info.size = offsetof(tg_world_info, frame);
  ASSERT_EQ(tg_world_get_info(c.world, &info), TG_OK) << tg_error();
  EXPECT_EQ(info.frame_dt, 0.02);
  EXPECT_EQ(info.frame, 0x7f7f7f7f) << "a field beyond the caller's struct was written";
}

// Structs of a newer, longer header are accepted, and their extra bytes are zeroed.
TEST(CVersions, AcceptsNewerStructs) {
  struct Newer {
    tg_world_def def;
    std::array<char, 64> more;
  } newer;
  newer.more.fill(9);
  ASSERT_EQ(tg_default_world_def(&newer.def, sizeof newer), TG_OK);
  EXPECT_EQ(newer.more[63], 0);
  newer.def.text = kPad;
  const OwnedWorld c(newer.def);
  struct NewerCommand {
    tg_command command;
    double more = 1e300;
  };
  const NewerCommand commands[2] = {{finger_at(0.035)}, {finger_at(0.034)}};
  tg_reading readings[2];
  ASSERT_EQ(tg_world_tick(c.world, &commands[0].command, sizeof commands[0], readings, sizeof readings[0], 2),
            TG_OK)
      << tg_error();
  EXPECT_GT(readings[1].force[2], 0);
}

// The version check accepts the current version and rejects newer ones with a message.
TEST(CVersions, ComparesVersions) {
  EXPECT_EQ(tg_check_version(TG_VERSION), TG_OK);
  EXPECT_EQ(tg_version(), TG_VERSION);
  EXPECT_EQ(tg_check_version(TG_VERSION + 10000), TG_MISUSE);
  EXPECT_EQ(tg_check_version(TG_VERSION + 1), TG_MISUSE);
  EXPECT_NE(std::string(tg_error()).find(std::to_string(TG_VERSION + 1)), std::string::npos);
}

}  // namespace
}  // namespace turgor

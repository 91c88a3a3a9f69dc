// A needle that C leads: what it feels, and its report.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/world_def.hpp"

namespace turgor {
namespace {

// It goes 15 mm into a block and comes out again, at 50 mm/s. The force rises until the tip punctures; the
// shaft's friction grows with the length inside, and holds the needle back as it leaves.
TEST(CNeedle, StrokeIsFeltAndReported) {
  constexpr double kTop = 0.03, kFriction = 4;  // [m] [N/m]
  const std::string text = test::pad_scene(R"([tool.needle]
body = "pad"
shape = { needle = 0.06, diameter = 0.001, shaft_friction = 4, spreading = 0 }
path = [[0, 0.031, 0.028, 0.05]]
)");
  const tg_world_def def = test::def_of(text.c_str());
  tg_world* world = nullptr;
  ASSERT_EQ(tg_world_create(&def, &world), TG_OK) << tg_error();
  std::vector<tg_command> commands;
  std::vector<double> depths;
  for (int n = 1; n <= 660; n++) {
    depths.push_back(0.015 - std::abs(0.016 - 5e-5 * n));
    commands.push_back({{0.031, 0.028, kTop - depths.back()}, {1, 0, 0, 0}, 0, 0});
  }
  std::vector<tg_reading> readings(commands.size());
  ASSERT_EQ(tg_world_tick(world, commands.data(), sizeof commands[0], readings.data(), sizeof readings[0],
                          std::int32_t(commands.size())),
            TG_OK)
      << tg_error();
  const auto force = [&](int n) { return readings[std::size_t(n)].force[2]; };
  const auto growth = [&](int from, int to) {
    return (std::abs(force(to)) - std::abs(force(from))) /
           (depths[std::size_t(to)] - depths[std::size_t(from)]);
  };
  EXPECT_GT(force(100), 0.25);
  EXPECT_NEAR(growth(200, 300), kFriction, 0.1 * kFriction);
  EXPECT_NEAR(growth(400, 500), kFriction, 0.1 * kFriction);
  EXPECT_LT(force(450), 0);
  EXPECT_EQ(force(650), 0);
  double punctures = 0;
  std::size_t count = 0;
  EXPECT_EQ(tg_world_measure(world, "tools.needle.needle.punctures", &punctures, 1, &count), TG_OK)
      << tg_error();
  EXPECT_EQ(punctures, 1);
  EXPECT_EQ(tg_world_destroy(world), TG_OK);
}

}  // namespace
}  // namespace turgor

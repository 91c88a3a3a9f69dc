#include "turgor/window/parameters.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace turgor {
namespace {

constexpr const char* kText = R"([world]
gravity = [0, 0, -9.81]
[body.torso]
model = "lattice"
ct = { phantom = "torso" }
skin = { tension = 60 }
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [1, 0, 0], up = [0, 0, 1], columns = 4, rows = 4 }
)";

Scene scene(const std::vector<std::string>& overrides = {}) {
  Result<Scene> read = parse_scene(kText, "a.toml", overrides);
  EXPECT_TRUE(read) << read.error().message;
  return *read;
}

const Parameter& find(const ParameterList& list, const std::string& path) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const Parameter& p) { return p.key.path == path; });
  EXPECT_NE(found, list.end()) << path;
  return *found;
}

TEST(parameters, numbers_come_with_unit_limits_and_the_value_that_holds_now) {
  const ParameterList list = list_parameters(scene());
  const Parameter& tension = find(list, "body.torso.skin.tension");
  EXPECT_EQ(tension.value[0], 60) << "as the file says";
  EXPECT_EQ(tension.key.unit, "N/m");
  EXPECT_EQ(tension.key.allowed.low, 0);
  EXPECT_TRUE(tension.is_live);
  EXPECT_EQ(find(list, "body.torso.skin.stiffness").value[0], 300) << "what holds without it";
  const Parameter& gravity = find(list, "world.gravity");
  EXPECT_EQ(gravity.count, 3);
  EXPECT_EQ(gravity.value[2], -9.81);
  const ParameterList changed = list_parameters(scene({"body.torso.skin.tension=75"}));
  EXPECT_EQ(find(changed, "body.torso.skin.tension").value[0], 75) << "as it was changed";
}

TEST(parameters, those_that_act_at_once_come_first_and_the_rest_says_that_it_does_not) {
  const ParameterList list = list_parameters(scene());
  EXPECT_TRUE(std::is_partitioned(list.begin(), list.end(), [](const Parameter& p) { return p.is_live; }));
  EXPECT_FALSE(find(list, "body.torso.tissue.fat").is_live) << "is in the stiffness of every spring";
  EXPECT_TRUE(find(list, "body.flag.wind.velocity").is_live);
}

TEST(parameters, a_value_turned_in_the_window_is_one_that_the_scene_takes) {
  for (Parameter parameter : list_parameters(scene())) {
    for (double& value : parameter.value) value = limited(parameter.key.allowed, value * 1.03);
    const Result<Scene> taken =
        parse_scene(kText, "a.toml", {parameter.key.path + "=" + value_text(parameter)});
    EXPECT_TRUE(taken || !parameter.is_live) << parameter.key.path;
  }
}

TEST(parameters, values_are_held_within_limits_and_off_those_that_are_refused) {
  EXPECT_EQ(limited(within(0, 10), 12), 10);
  EXPECT_EQ(limited(not_negative(""), -3), 0);
  EXPECT_GT(limited(positive(""), -3), 0);
}

}  // namespace
}  // namespace turgor

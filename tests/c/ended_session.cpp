#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/world_def.hpp"

namespace turgor {
namespace {

// After tg_touch_end, refused calls name what goes on: a copy from before tg_touch_begin, or a new world.
TEST(CEndedSession, NamesWayBack) {
  const std::string scene = test::pad_scene(R"([tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.03, 0.03, 0.04], [0.2, 0.03, 0.03, 0.032]]
)");
  const tg_world_def def = test::def_of(scene.c_str());
  tg_world *world = nullptr, *before = nullptr, *after = nullptr;
  ASSERT_EQ(tg_world_create(&def, &world), TG_OK) << tg_error();
  ASSERT_EQ(tg_world_step(world, 1), TG_OK) << tg_error();
  ASSERT_EQ(tg_world_copy(world, &before), TG_OK) << tg_error();
  const tg_command command{{0.03, 0.03, 0.035}, {1, 0, 0, 0}, 0, 0};
  tg_reading reading;
  ASSERT_EQ(tg_touch_begin(world), TG_OK) << tg_error();
  ASSERT_EQ(tg_touch_tick(world, &command, sizeof command, &reading, sizeof reading), TG_OK) << tg_error();
  ASSERT_EQ(tg_touch_end(world), TG_OK) << tg_error();
  ASSERT_EQ(tg_world_copy(world, &after), TG_OK) << tg_error();

  const std::function<tg_status(tg_world*)> calls[] = {
      [](tg_world* w) { return tg_world_step(w, 1); },
      [&](tg_world* w) { return tg_world_tick(w, &command, sizeof command, &reading, sizeof reading, 1); },
      [](tg_world* w) { return tg_touch_begin(w); },
      [](tg_world* w) { return tg_world_save(w, "unwritten.state"); },
      [](tg_world* w) { return tg_world_load(w, "unwritten.state"); }};
  for (tg_world* ended : {world, after})
    for (const auto& call : calls) {
      EXPECT_EQ(call(ended), TG_MISUSE);
      EXPECT_STREQ(tg_error(),
                   "expected a new world, or a copy from before tg_touch_begin, found a world whose haptic "
                   "session has ended");
    }
  EXPECT_EQ(tg_world_step(before, 1), TG_OK) << tg_error();
  EXPECT_EQ(tg_touch_begin(before), TG_OK) << tg_error();
  for (tg_world* one : {world, before, after}) EXPECT_EQ(tg_world_destroy(one), TG_OK) << tg_error();
}

}  // namespace
}  // namespace turgor

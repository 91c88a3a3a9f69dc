// Forces between bodies that C reads by their names.
#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/world_def.hpp"

namespace turgor {
namespace {

// A table bears the weight of the stone on it.
TEST(CBodyContact, ForceIsMeasuredByName) {
  const tg_world_def def = test::def_of(R"([world]
gravity = [0, 0, -9.81]
duration = 5
[body.stone]
model = "rigid"
shape = { box = [0.04, 0.03, 0.02] }
at = [0, 0, 0.0105]
mass = 0.05
[body.table]
model = "rigid"
shape = { box = [0.2, 0.2, 0.02] }
at = [0, 0, -0.01]
mass = 1
fixed = true
[contact.board]
between = ["stone", "table"]
)");
  tg_world* world = nullptr;
  ASSERT_EQ(tg_world_create(&def, &world), TG_OK) << tg_error();
  ASSERT_EQ(tg_world_step(world, 60), TG_OK) << tg_error();
  double force = 9;
  std::size_t count = 0;
  ASSERT_EQ(tg_world_measure(world, "body_contacts.board.force_z_N", &force, 1, &count), TG_OK) << tg_error();
  EXPECT_EQ(count, 1u);
  EXPECT_NEAR(force, 0.05 * 9.81, 1e-3 * 0.05 * 9.81);
  EXPECT_EQ(tg_world_destroy(world), TG_OK) << tg_error();
}

}  // namespace
}  // namespace turgor

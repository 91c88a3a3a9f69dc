// Values of the C interface: states, measures, topology, commands.
#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/owned_world.hpp"
#include "tests/folders.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using test::def_of;
using test::finger_at;
using test::hash_of;
using test::kPad;
using test::OwnedWorld;

const char* const kCut = R"([world]
duration = 1
frame_rate = 50
[body.block]
model = "lattice"
ct = "given in memory"
block = 2
fixed = "bone"
[incision.cut]
body = "block"
from_fraction = [0.5, 0, 0.2]
to_fraction = [0.5, 0, 0.8]
depth = 0.01
start = 0.03
duration = 0.04
)";

// A world of the C interface reaches the same bits as one of the C++ library.
TEST(CInterface, StateEqualsLibrary) {
  const OwnedWorld c(kPad);
  ASSERT_EQ(tg_world_step(c.world, 12), TG_OK) << tg_error();
  const Exec exec(1);
  const Result<Scene> scene = parse_scene(kPad, "scene.toml");
  ASSERT_TRUE(scene);
  Result<World> world = load_world(exec, *scene);
  ASSERT_TRUE(world);
  for (int frame = 0; frame < 12; frame++) ASSERT_TRUE(step(exec, *world));
  EXPECT_EQ(hash_of(c.world), state_hash(*world));
  EXPECT_GT(norm(world->tools[0].samples.back().force), 0.01);
}

// A cut through a volume passed in memory changes the topology version and adds triangles.
TEST(CInterface, CutChangesTopologyOfVolume) {
  std::vector<std::int16_t> hu;
  for (int k = 0; k < 24; k++)
    for (int j = 0; j < 24; j++)
      for (int i = 0; i < 24; i++) {
        const bool inside = i > 3 && i < 20 && j > 3 && j < 20 && k > 3 && k < 20;
        hu.push_back(!inside ? -1000 : j > 16 ? 700 : 40);
      }
  tg_volume volume{sizeof volume,      "block",   {24, 24, 24},
                   {2e-3, 2e-3, 2e-3}, {0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1},
                   hu.data()};
  tg_world_def def = def_of(kCut);
  def.volumes = &volume, def.volume_count = 1;
  const OwnedWorld c(def);
  tg_body_info before{sizeof before, nullptr, nullptr, 0, 0, 0}, after = before;
  ASSERT_EQ(tg_body_get_info(c.world, 0, &before), TG_OK) << tg_error();
  EXPECT_STREQ(before.model, "lattice");
  ASSERT_EQ(tg_world_step(c.world, 5), TG_OK) << tg_error();
  ASSERT_EQ(tg_body_get_info(c.world, 0, &after), TG_OK) << tg_error();
  EXPECT_NE(before.topology_version, after.topology_version);
  EXPECT_GT(after.triangles, before.triangles);
  double depth = 0;
  ASSERT_EQ(tg_world_measure(c.world, "wounds.cut.depth_mm", &depth, 1, nullptr), TG_OK) << tg_error();
  EXPECT_NEAR(depth, 10, 1e-9);
  std::vector<std::int32_t> triangles(std::size_t(after.triangles) * 3);
  ASSERT_EQ(tg_body_triangles(c.world, 0, triangles.data(), triangles.size(), nullptr), TG_OK);
  EXPECT_EQ(*std::max_element(triangles.begin(), triangles.end()), after.vertices - 1);
  volume.origin[1] = 1e308;
  tg_world* far = nullptr;
  EXPECT_EQ(tg_world_create(&def, &far), TG_ERROR);
  EXPECT_NE(std::string(tg_error()).find("the volume of block: expected samples within 1e+09 m"),
            std::string::npos)
      << tg_error();
  volume.origin[1] = 0;
  volume.body = "nobody";
  tg_world* world = nullptr;
  EXPECT_EQ(tg_world_create(&def, &world), TG_ERROR);
}

// The report reaches the caller as text and as numbers: an attachment bears the weight of the body that hangs
// from it, and a path without a number is refused with its first unknown key.
TEST(CInterface, MeasuresOfTheReport) {
  const OwnedWorld c(R"([world]
gravity = [0, 0, -9.81]
duration = 5
[body.stone]
model = "sfem"
block = { size = [0.04, 0.03, 0.02], count = [4, 3, 2] }
fixed = "none"
density = 1000
cache = false
[attachment.rope]
between = ["stone", "ground"]
box = [[-1, -1, 0.0199], [1, 1, 1]]
stiffness = 40
)");
  ASSERT_EQ(tg_world_step(c.world, 300), TG_OK) << tg_error();
  double force = 9;
  std::size_t count = 0;
  const auto measure = [&](const char* path, std::size_t capacity) {
    return tg_world_measure(c.world, path, &force, capacity, &count);
  };
  ASSERT_EQ(measure("attachments.rope.force_N", 1), TG_OK) << tg_error();
  EXPECT_EQ(count, 1u);
  const double weight = 0.04 * 0.03 * 0.02 * 1000 * 9.81;
  EXPECT_NEAR(force, weight, 1e-3 * weight);
  EXPECT_EQ(measure("attachments.rope.force_N", 0), TG_MISUSE);
  EXPECT_EQ(count, 1u);
  EXPECT_EQ(measure("attachments.chain.force_N", 1), TG_ERROR);
  EXPECT_STREQ(tg_error(), "expected a number of the report as attachments.chain.force_N, found no chain");
  EXPECT_EQ(measure("attachments.rope", 1), TG_ERROR);
  EXPECT_EQ(measure(nullptr, 1), TG_MISUSE);

  ASSERT_EQ(tg_world_report(c.world, nullptr, 0, &count), TG_MISUSE);
  std::string text(count, '\0');
  ASSERT_EQ(tg_world_report(c.world, text.data(), text.size(), &count), TG_OK) << tg_error();
  EXPECT_EQ(text.find('\0'), text.size() - 1);
  EXPECT_NE(text.find("\"attachments\":[{"), std::string::npos);
}

// A copy of a world continues to the same bits as the original.
TEST(CInterface, CopyReachesEqualBits) {
  const OwnedWorld c(kPad);
  std::vector<tg_command> commands(50, finger_at(0.0335));
  std::vector<tg_reading> readings(50), others(50);
  const auto tick = [&](tg_world* world, std::vector<tg_reading>& haptic) {
    return tg_world_tick(world, commands.data(), sizeof commands[0], haptic.data(), sizeof haptic[0], 50);
  };
  ASSERT_EQ(tick(c.world, readings), TG_OK) << tg_error();
  tg_world* copy = nullptr;
  ASSERT_EQ(tg_world_copy(c.world, &copy), TG_OK) << tg_error();
  for (tg_command& command : commands) command.position[0] = 0.02;
  ASSERT_EQ(tick(c.world, readings), TG_OK);
  ASSERT_EQ(tick(copy, others), TG_OK);
  EXPECT_EQ(std::memcmp(readings.data(), others.data(), 50 * sizeof(tg_reading)), 0);
  EXPECT_EQ(hash_of(c.world), hash_of(copy));
  EXPECT_GT(readings[49].force[2], 0.005);
  EXPECT_EQ(tg_world_step(copy, 1), TG_MISUSE);
  tg_world_destroy(copy);
}

// A state that was saved before the patch followed its tool is loaded after two other patches, with the log
// of forces of its time.
TEST(CInterface, LoadsStateOfEarlierPatch) {
  const std::string file = (test::fresh_folder() / "world.state").string();
  std::string text = test::pad_scene(R"([tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.015, 0.03, 0.0345], [0.8, 0.045, 0.03, 0.0345]]
)");
  text.replace(text.find("cache"), 0, "patch = { radius = 0.008 }\n");
  const OwnedWorld c(text.c_str()), fresh(text.c_str());
  ASSERT_EQ(tg_world_save(c.world, file.c_str()), TG_OK) << tg_error();
  const std::uint64_t begin = hash_of(c.world);
  ASSERT_EQ(tg_world_step(c.world, 45), TG_OK) << tg_error();
  ASSERT_EQ(tg_world_load(c.world, file.c_str()), TG_OK) << tg_error();
  EXPECT_EQ(hash_of(c.world), begin);
  ASSERT_EQ(tg_world_step(c.world, 45), TG_OK) << tg_error();
  ASSERT_EQ(tg_world_step(fresh.world, 45), TG_OK) << tg_error();
  EXPECT_EQ(hash_of(c.world), hash_of(fresh.world));
}

// The command of a tool on cloth comes from its path also after ticks that moved it elsewhere.
TEST(CInterface, CommandFollowsPathBesideTicks) {
  const char* const sheet = R"([world]
duration = 1
frame_rate = 50
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.1, 0, 0], up = [0, 0.1, 0], columns = 12, rows = 12 }
[body.sheet.hold.edge]
box = [[-1, 0.09, -1], [1, 1, 1]]
[tool.ball]
body = "sheet"
shape = { sphere = 0.01 }
path = [[0, 0.05, 0.05, 0.05], [1, 0.05, 0.05, 0.15]]
)";
  const OwnedWorld c(sheet), path(sheet);
  tg_command command, wanted;
  tg_reading reading;
  std::vector<tg_command> elsewhere(100, tg_command{{0.02, 0.02, 0.05}, {1, 0, 0, 0}, 0, 0});
  std::vector<tg_reading> readings(elsewhere.size(), reading);
  ASSERT_EQ(tg_world_tick(c.world, elsewhere.data(), sizeof command, readings.data(), sizeof reading, 100),
            TG_OK)
      << tg_error();
  ASSERT_EQ(tg_tool_get_command(c.world, 0, &command), TG_OK) << tg_error();
  ASSERT_EQ(tg_world_step(path.world, 5), TG_OK) << tg_error();
  ASSERT_EQ(tg_tool_get_command(path.world, 0, &wanted), TG_OK) << tg_error();
  for (int axis = 0; axis < 3; axis++) EXPECT_NEAR(command.position[axis], wanted.position[axis], 1e-12);
  EXPECT_GT(wanted.position[2], 0.052);
}

}  // namespace
}  // namespace turgor

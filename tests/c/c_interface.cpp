#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <turgor.h>

#include "c/guard.hpp"
#include "tests/c/world_def.hpp"
#include "tests/folders.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using test::def_of;

const std::string kPadText = test::pad_scene(R"([tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.03, 0.03, 0.04], [0.2, 0.03, 0.03, 0.032]]
)");
const char* const kPad = kPadText.c_str();
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

struct Owned {
  tg_world* world = nullptr;
  explicit Owned(const tg_world_def& def) { EXPECT_EQ(tg_world_create(&def, &world), TG_OK) << tg_error(); }
  explicit Owned(const char* text) : Owned(def_of(text)) {}
  ~Owned() { EXPECT_EQ(tg_world_destroy(world), TG_OK) << tg_error(); }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
};

std::uint64_t hash_of(tg_world* world) {
  std::uint64_t hash = 0;
  EXPECT_EQ(tg_world_state_hash(world, &hash), TG_OK) << tg_error();
  return hash;
}

tg_command finger_at(double z) { return {{0.03, 0.03, z}, {1, 0, 0, 0}, 0, 0}; }

// A world of the C interface reaches the same bits as one of the C++ library.
TEST(CInterface, StateEqualsLibrary) {
  const Owned c(kPad);
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

// Structs of an older, shorter header are accepted, and nothing is written beyond their size.
TEST(CInterface, AcceptsOlderStructs) {
  tg_world_def def = def_of(kPad);
  def.size = offsetof(tg_world_def, folder);  // the size of an older struct
  std::memset(reinterpret_cast<char*>(&def) + def.size, 0x7f, sizeof def - def.size);
  const Owned c(def);
  tg_world_info info;
  std::memset(static_cast<void*>(&info), 0x7f, sizeof info);
  info.size = offsetof(tg_world_info, frame);
  ASSERT_EQ(tg_world_get_info(c.world, &info), TG_OK) << tg_error();
  EXPECT_EQ(info.frame_dt, 0.02);
  EXPECT_EQ(info.frame, 0x7f7f7f7f) << "a field beyond the caller's struct was written";
}

// Structs of a newer, longer header are accepted, and their extra bytes are zeroed.
TEST(CInterface, AcceptsNewerStructs) {
  struct Newer {
    tg_world_def def;
    std::array<char, 64> more;
  } newer;
  newer.more.fill(9);
  ASSERT_EQ(tg_default_world_def(&newer.def, sizeof newer), TG_OK);
  EXPECT_EQ(newer.more[63], 0);
  newer.def.text = kPad;
  const Owned c(newer.def);
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
TEST(CInterface, ComparesVersions) {
  EXPECT_EQ(tg_check_version(TG_VERSION), TG_OK);
  EXPECT_EQ(tg_version(), TG_VERSION);
  EXPECT_EQ(tg_check_version(TG_VERSION + 10000), TG_MISUSE);
  EXPECT_EQ(tg_check_version(TG_VERSION + 1), TG_MISUSE);
  EXPECT_NE(std::string(tg_error()).find(std::to_string(TG_VERSION + 1)), std::string::npos);
}

// Errors of a scene are reported as a message; the next success clears it.
TEST(CInterface, SceneErrorsHaveMessage) {
  tg_world* world = nullptr;
  tg_world_def def = def_of("[body.pad]\nmodel = \"jelly\"\n");
  EXPECT_EQ(tg_world_create(&def, &world), TG_ERROR);
  EXPECT_EQ(world, nullptr);
  EXPECT_NE(std::string(tg_error()).find("jelly"), std::string::npos);
  def = def_of(kPad);
  def.scene = "also.toml";
  EXPECT_EQ(tg_world_create(&def, &world), TG_MISUSE);
  EXPECT_STRNE(tg_error(), "");
  EXPECT_EQ(tg_world_destroy(nullptr), TG_OK);
  EXPECT_STREQ(tg_error(), "");
}

// Null arguments of every function are errors and never crash.
TEST(CInterface, NullArgumentsAreErrors) {
  tg_world* none = nullptr;
  EXPECT_NE(tg_default_world_def(nullptr, sizeof(tg_world_def)), TG_OK);
  EXPECT_NE(tg_world_create(nullptr, nullptr), TG_OK);
  EXPECT_NE(tg_world_create(nullptr, &none), TG_OK);
  const Owned owned(kPad);
  for (tg_world* world : {none, owned.world}) {
    EXPECT_NE(tg_world_copy(world, nullptr), TG_OK);
    EXPECT_NE(tg_world_get_info(world, nullptr), TG_OK);
    EXPECT_NE(tg_world_state_hash(world, nullptr), TG_OK);
    EXPECT_NE(tg_world_step(world, -1), TG_OK);
    EXPECT_NE(tg_body_find(world, nullptr, nullptr), TG_OK);
    EXPECT_NE(tg_body_get_info(world, 0, nullptr), TG_OK);
    EXPECT_NE(tg_body_read(world, 0, TG_POINTS, nullptr, 1000000, nullptr), TG_OK);
    EXPECT_NE(tg_body_triangles(world, 0, nullptr, 1000000, nullptr), TG_OK);
    EXPECT_NE(tg_tool_find(world, nullptr, nullptr), TG_OK);
    EXPECT_NE(tg_tool_get_info(world, 0, nullptr), TG_OK);
    EXPECT_NE(tg_tool_get_command(world, 0, nullptr), TG_OK);
    EXPECT_NE(tg_touch_tick(world, nullptr, sizeof(tg_command), nullptr, sizeof(tg_reading)), TG_OK);
    EXPECT_NE(tg_touch_end(world), TG_OK);
    EXPECT_NE(tg_world_tick(world, nullptr, sizeof(tg_command), nullptr, sizeof(tg_reading), 1), TG_OK);
  }
  EXPECT_NE(tg_touch_begin(none), TG_OK);
}

// Random arguments, including values outside of the enums, never crash.
TEST(CInterface, RandomArgumentsNeverCrash) {
  const Owned owned(kPad);
  std::mt19937 random(1);
  const auto number = [&random] { return std::int32_t(random() % 9) - 3; };
  std::array<float, 16> few{};
  std::array<std::int32_t, 16> corners{};
  for (int n = 0; n < 2000; n++) {
    tg_world* world = random() % 8 ? owned.world : nullptr;
    std::size_t count = 0;
    float* floats = random() % 2 ? few.data() : nullptr;
    std::int32_t* ints = random() % 2 ? corners.data() : nullptr;
    tg_body_info body{random() % 2 ? sizeof(tg_body_info) : random() % 64, nullptr, nullptr, 0, 0, 0};
    tg_tool_info tool{random() % 2 ? sizeof(tg_tool_info) : random() % 16, nullptr, 0};
    EXPECT_NE(tg_body_read(world, number(), number(), floats, floats ? few.size() : 0,
                           random() % 2 ? &count : nullptr),
              TG_BROKEN);
    EXPECT_NE(tg_body_triangles(world, number(), ints, ints ? corners.size() : 0, nullptr), TG_BROKEN);
    EXPECT_NE(tg_body_get_info(world, number(), &body), TG_BROKEN) << tg_error();
    EXPECT_NE(tg_tool_get_info(world, number(), &tool), TG_BROKEN) << tg_error();
    EXPECT_NE(tg_body_find(world, random() % 2 ? "pad" : "liver", random() % 2 ? ints : nullptr), TG_BROKEN);
    tg_command command = finger_at(random() % 2 ? 0.035 : NAN);
    command.orientation[0] = random() % 3 ? 2 : 0;
    tg_reading reading;
    const std::size_t size = random() % 2 ? sizeof command : random() % 56;
    EXPECT_NE(tg_world_tick(world, random() % 4 ? &command : nullptr, size, &reading, sizeof reading, 1),
              TG_BROKEN)
        << tg_error();
  }
}

// A buffer that is too short is an error and is not written.
TEST(CInterface, ShortBufferIsNotWritten) {
  const Owned c(kPad);
  std::size_t count = 0;
  EXPECT_EQ(tg_body_read(c.world, 0, TG_REST, nullptr, 0, &count), TG_MISUSE);
  std::vector<float> buffer(count, 7);
  EXPECT_EQ(tg_body_read(c.world, 0, TG_REST, buffer.data(), count - 1, nullptr), TG_MISUSE);
  EXPECT_EQ(buffer, std::vector<float>(count, 7));
  EXPECT_EQ(tg_body_read(c.world, 0, TG_REST, buffer.data(), count, nullptr), TG_OK) << tg_error();
  EXPECT_NEAR(*std::max_element(buffer.begin(), buffer.end()), 0.06, 1e-6);
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
  const Owned c(def);
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
  const Owned c(R"([world]
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

// A number of threads that no machine has is the caller's error, not a crash.
TEST(CInterface, RejectsThreadsOutOfRange) {
  for (const std::int32_t threads : {-1, 1025, 5000, 2147483647}) {
    tg_world_def def = def_of(kPad);
    def.threads = threads;
    tg_world* world = nullptr;
    EXPECT_EQ(tg_world_create(&def, &world), TG_MISUSE);
    EXPECT_EQ(world, nullptr);
    EXPECT_EQ(std::string(tg_error()),
              fmt::format("expected a number of threads from 0 (one per core) to 1024, found {}", threads));
  }
}

// A copy of a world continues to the same bits as the original.
TEST(CInterface, CopyReachesEqualBits) {
  const Owned c(kPad);
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
  const Owned c(text.c_str()), fresh(text.c_str());
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
  const Owned c(sheet), path(sheet);
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

// A haptic thread receives forces while another thread steps the frames.
TEST(CInterface, HapticThreadRunsBesideFrames) {
  const Owned c(kPad);
  ASSERT_EQ(tg_touch_begin(c.world), TG_OK) << tg_error();
  std::atomic<bool> ends{false};
  double haptic = 0;
  std::atomic<int> bad{0}, ticks{0};
  std::thread haptic_thread([&] {
    tg_reading reading;
    while (!ends || ticks < 200) {
      const tg_command command = finger_at(0.036 - 1e-5 * std::min(ticks.load(), 300));
      bad += tg_touch_tick(c.world, &command, sizeof command, &reading, sizeof reading) != TG_OK;
      haptic = std::max(haptic, reading.force[2]);
      ticks++;
    }
  });
  for (int frame = 0; frame < 10; frame++) {
    tg_body_info info{sizeof info, nullptr, nullptr, 0, 0, 0};
    EXPECT_EQ(tg_world_step(c.world, 1), TG_OK) << tg_error();
    EXPECT_EQ(tg_body_get_info(c.world, 0, &info), TG_OK) << tg_error();
  }
  ends = true;
  haptic_thread.join();
  EXPECT_EQ(bad, 0);
  EXPECT_GT(haptic, 0.01);
  EXPECT_EQ(tg_touch_end(c.world), TG_OK) << tg_error();
  EXPECT_EQ(tg_touch_begin(c.world), TG_MISUSE);
}

// Steps from two threads at once are refused.
TEST(CInterface, RejectsConcurrentSteps) {
  const Owned c(kPad);
  std::atomic<int> refused{0}, others{0};
  const auto step = [&] {
    for (int n = 0; n < 300; n++) {
      const tg_status status = tg_world_step(c.world, 1);
      refused += status == TG_MISUSE, others += status != TG_MISUSE && status != TG_OK;
    }
  };
  std::thread beside(step);
  step();
  beside.join();
  EXPECT_GT(refused, 0);
  EXPECT_EQ(others, 0);
}

// Failed assertions and exceptions become status codes with a message.
TEST(CGuard, MapsExceptionsToStatus) {
  EXPECT_EQ(c::guarded([] { TURGOR_ASSERT(1 < 0, "one is less than none"); }), TG_BROKEN);
  EXPECT_NE(std::string(c::current_error()).find("one is less than none"), std::string::npos);
  EXPECT_EQ(c::guarded([] { throw std::bad_alloc(); }), TG_NO_MEMORY);
  EXPECT_EQ(c::guarded([] { throw 7; }), TG_BROKEN);
  EXPECT_EQ(c::guarded([] {}), TG_OK);
  EXPECT_STREQ(c::current_error(), "");
}

}  // namespace
}  // namespace turgor

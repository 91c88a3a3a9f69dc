// Cuts and stitches of the C interface: bits of a scene, errors, arguments.
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <turgor.h>

#include "tests/c/world_def.hpp"
#include "tests/folders.hpp"

namespace turgor {
namespace {

/// Fat on bone with skin, uncut.
const char* const kBlock = R"([world]
duration = 2
frame_rate = 50
[body.block]
model = "lattice"
ct = "given in memory"
block = 2
fixed = "bone"
)";
const double kLine[] = {0.002, -0.02, -0.03, 0.002, -0.02, 0.03};
const double kThread[] = {-0.010, -0.019, 0.004, -0.010, -0.015, 0.004,
                          0.014,  -0.015, 0.004, 0.014,  -0.019, 0.004};

/// World of a block of 40 × 24 × 40 voxels of 4 mm in memory.
struct Block {
  tg_world* world = nullptr;
  std::vector<std::int16_t> hu;

  explicit Block(const std::string& text, int threads = 1) {
    for (int k = 0; k < 40; k++)
      for (int j = 0; j < 24; j++)
        for (int i = 0; i < 40; i++) {
          const bool inside = i >= 4 && i < 36 && j >= 4 && j < 20 && k >= 4 && k < 36;
          hu.push_back(!inside ? -1000 : j < 14 ? -100 : 1000);
        }
    tg_volume volume{sizeof volume,
                     "block",
                     {40, 24, 40},
                     {4e-3, 4e-3, 4e-3},
                     {-0.078, -0.036, -0.078},
                     {1, 0, 0, 0, 1, 0, 0, 0, 1},
                     hu.data()};
    tg_world_def def = test::def_of(text.c_str(), threads);
    def.volumes = &volume, def.volume_count = 1;
    EXPECT_EQ(tg_world_create(&def, &world), TG_OK) << tg_error();
  }
  ~Block() { EXPECT_EQ(tg_world_destroy(world), TG_OK) << tg_error(); }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;

  void step(int frames) const { EXPECT_EQ(tg_world_step(world, frames), TG_OK) << tg_error(); }
  double measure(const char* path) const {
    double value = 0;
    EXPECT_EQ(tg_world_measure(world, path, &value, 1, nullptr), TG_OK) << tg_error();
    return value;
  }
  std::uint64_t hash() const {
    std::uint64_t value = 0;
    EXPECT_EQ(tg_world_state_hash(world, &value), TG_OK) << tg_error();
    return value;
  }
};

tg_cut line_cut() {
  tg_cut cut;
  EXPECT_EQ(tg_default_cut(&cut, sizeof cut), TG_OK);
  cut.points = kLine, cut.point_count = 2, cut.depth = 0.012, cut.duration = 0.04;
  return cut;
}
tg_stitch loop_stitch(double tension) {
  tg_stitch stitch;
  EXPECT_EQ(tg_default_stitch(&stitch, sizeof stitch), TG_OK);
  stitch.points = kThread, stitch.point_count = 4, stitch.tension = tension, stitch.duration = 0.2;
  return stitch;
}

// A cut and a stitch by the caller have the bits of those of a scene, on any number of threads, and the
// report names them. A stitch is pulled further.
TEST(CByHand, HasBitsOfScene) {
  const Block scene(
      std::string(kBlock) +
      "[incision.cut]\nbody = \"block\"\nfrom = [0.002, -0.02, -0.03]\nto = [0.002, -0.02, 0.03]\n"
      "depth = 0.012\nstart = 0.04\nduration = 0.04\n"
      "[suture.one]\nwound = \"cut\"\nthrough = [[-0.010, -0.019, 0.004], [-0.010, -0.015, 0.004], "
      "[0.014, -0.015, 0.004], [0.014, -0.019, 0.004]]\ntension = 0.5\nstart = 0.18\n"
      "duration = 0.2\n");
  scene.step(30);
  for (const int threads : {1, 2}) {
    const Block block(kBlock, threads);
    block.step(2);
    const tg_cut cut = line_cut();
    const char* wound = nullptr;
    ASSERT_EQ(tg_world_cut(block.world, &cut, &wound), TG_OK) << tg_error();
    EXPECT_STREQ(wound, "hand-1");
    block.step(6);
    const tg_stitch stitch = loop_stitch(0.5);
    const char* name = nullptr;
    ASSERT_EQ(tg_world_stitch(block.world, &stitch, &name), TG_OK) << tg_error();
    EXPECT_STREQ(name, "hand-1");
    block.step(22);
    EXPECT_EQ(block.hash(), scene.hash());
    EXPECT_NEAR(block.measure("sutures.hand-1.tension_max_N"), 0.5, 0.1);
    // pulled further
    ASSERT_EQ(tg_world_tighten(block.world, name, 1, 0.1), TG_OK) << tg_error();
    const double gape = block.measure("wounds.hand-1.gape_max_mm");
    block.step(20);
    EXPECT_LT(block.measure("wounds.hand-1.gape_max_mm"), gape);
    EXPECT_GT(block.measure("sutures.hand-1.tension_max_N"), 0.7);
  }
}

// A saved world continues in another one with the same bits, with its cut, its stitch and their measures.
TEST(CByHand, SavedWorldContinues) {
  const std::string file = (test::fresh_folder() / "world.state").string();
  const Block block(kBlock), resumed(kBlock, 2);
  const tg_cut cut = line_cut();
  ASSERT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_OK) << tg_error();
  block.step(8);
  const tg_stitch stitch = loop_stitch(0.5);
  ASSERT_EQ(tg_world_stitch(block.world, &stitch, nullptr), TG_OK) << tg_error();
  block.step(6);
  ASSERT_EQ(tg_world_tighten(block.world, "hand-1", 0.8, 0.1), TG_OK) << tg_error();
  block.step(2);
  ASSERT_EQ(tg_world_save(block.world, file.c_str()), TG_OK) << tg_error();
  resumed.step(3);
  ASSERT_EQ(tg_world_load(resumed.world, file.c_str()), TG_OK) << tg_error();
  EXPECT_EQ(block.hash(), resumed.hash());
  for (const Block* one : {&block, &resumed}) {
    one->step(5);
    ASSERT_EQ(tg_world_tighten(one->world, "hand-1", 0.4, 0.1), TG_OK) << tg_error();
    one->step(5);
  }
  EXPECT_EQ(block.hash(), resumed.hash());
  EXPECT_EQ(block.measure("sutures.hand-1.tension_max_N"), resumed.measure("sutures.hand-1.tension_max_N"));
  // another scene, and no file
  const Block other(std::string(kBlock) + "gravity = false\n");
  const std::uint64_t before = other.hash();
  EXPECT_EQ(tg_world_load(other.world, file.c_str()), TG_ERROR);
  EXPECT_NE(std::string(tg_error()).find("of another scene"), std::string::npos) << tg_error();
  EXPECT_EQ(tg_world_load(other.world, (file + "-missing").c_str()), TG_ERROR);
  EXPECT_EQ(other.hash(), before);
  EXPECT_EQ(tg_world_load(other.world, nullptr), TG_MISUSE);
}

// A loaded state replaces a cut by another one of as many edges: points, triangles and the version of the
// topology are those of the new one.
TEST(CByHand, LoadReplacesSurface) {
  const std::string file = (test::fresh_folder() / "world.state").string();
  const Block block(kBlock), fresh(kBlock);
  ASSERT_EQ(tg_world_save(block.world, file.c_str()), TG_OK) << tg_error();
  std::vector<std::uint64_t> versions;
  const auto cut_at = [&](const Block& one, double x) {
    const double line[] = {x, -0.02, -0.03, x, -0.02, 0.03};
    tg_cut cut = line_cut();
    cut.points = line, cut.duration = 0;
    EXPECT_EQ(tg_world_cut(one.world, &cut, nullptr), TG_OK) << tg_error();
    one.step(1);
    tg_body_info info{sizeof info, nullptr, nullptr, 0, 0, 0};
    EXPECT_EQ(tg_body_get_info(one.world, 0, &info), TG_OK) << tg_error();
    versions.push_back(info.topology_version);
    std::vector<float> rest(3 * std::size_t(info.vertices));
    EXPECT_EQ(tg_body_read(one.world, 0, TG_REST, rest.data(), rest.size(), nullptr), TG_OK) << tg_error();
    return rest;
  };
  const std::vector<float> first = cut_at(block, 0.002);
  ASSERT_EQ(tg_world_load(block.world, file.c_str()), TG_OK) << tg_error();
  const std::vector<float> second = cut_at(block, 0.010);
  EXPECT_NE(first, second);
  EXPECT_NE(versions[0], versions[1]);
  EXPECT_EQ(second, cut_at(fresh, 0.010));
}

// An excision of a scene and the row of stitches that closes it have their measures, on any number of
// threads.
TEST(CByHand, ExcisionIsMeasured) {
  std::uint64_t hashes[2];
  for (const int threads : {1, 2}) {
    const Block block(std::string(kBlock) +
                          "[excision.mole]\nbody = \"block\"\ncenter = [0.002, -0.02, 0.001]\n"
                          "length = 0.05\nwidth = 0.03\ndepth = 0.012\nstart = 0.02\nduration = 0.04\n"
                          "[suture.row]\nwound = \"mole\"\nbite = 0.008\ndepth = 0.003\nspacing = 0.01\n"
                          "start = 0.1\nduration = 0.3\n",
                      threads);
    block.step(30);
    // fat of -100 HU
    EXPECT_NEAR(block.measure("wounds.mole.specimen.mass_g"),
                0.9 * block.measure("wounds.mole.specimen.volume_ml"), 1e-3);
    EXPECT_NEAR(block.measure("wounds.mole.marked.length_mm"), 50, 0.1);
    EXPECT_EQ(block.measure("sutures.row.stitches_bearing"), 5);
    EXPECT_GT(block.measure("sutures.row.closing_force_N"), 0.1);
    hashes[threads - 1] = block.hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Cuts and stitches that a world cannot have are refused with the reason, and change nothing.
TEST(CByHand, RefusesWithReason) {
  const Block block(kBlock), untouched(kBlock);
  const auto contains = [](const char* words) {
    return std::string(tg_error()).find(words) != std::string::npos ? "" : tg_error();
  };
  const tg_stitch stitch = loop_stitch(0);
  EXPECT_EQ(tg_world_stitch(block.world, &stitch, nullptr), TG_ERROR);
  EXPECT_STREQ(contains("both sides of a complete cut"), "");
  tg_cut cut = line_cut();
  cut.depth = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_ERROR);
  EXPECT_STREQ(contains("expected a depth above 0 and below 1 m, found nan"), "");
  cut = line_cut(), cut.point_count = 1;
  EXPECT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_ERROR);
  EXPECT_STREQ(contains("at least two points"), "");
  cut = line_cut(), cut.name = "not a name";
  EXPECT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_ERROR);
  EXPECT_STREQ(contains("found not a name"), "");
  const double air[] = {0, 1, 0, 0.1, 1, 0};
  cut = line_cut(), cut.points = air;
  EXPECT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_ERROR);
  EXPECT_STREQ(contains("skin"), "");
  EXPECT_EQ(tg_world_tighten(block.world, "hand-1", 1, 0.1), TG_ERROR);
  EXPECT_STREQ(contains("no stitch by hand hand-1"), "");
  // errors of the caller
  cut = line_cut(), cut.body = 1;
  EXPECT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_MISUSE);
  cut = line_cut(), cut.points = nullptr;
  EXPECT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_MISUSE);
  EXPECT_EQ(tg_world_cut(block.world, nullptr, nullptr), TG_MISUSE);
  EXPECT_EQ(tg_world_cut(nullptr, &cut, nullptr), TG_MISUSE);
  EXPECT_EQ(tg_world_stitch(block.world, nullptr, nullptr), TG_MISUSE);
  EXPECT_EQ(tg_world_tighten(block.world, nullptr, 1, 0.1), TG_MISUSE);
  EXPECT_EQ(tg_default_cut(nullptr, sizeof cut), TG_MISUSE);
  EXPECT_EQ(tg_default_stitch(nullptr, sizeof stitch), TG_MISUSE);
  block.step(3), untouched.step(3);
  EXPECT_EQ(block.hash(), untouched.hash());
}

// A struct of an older, shorter header is accepted; the members beyond it have their defaults.
TEST(CByHand, AcceptsOlderStructs) {
  const Block block(kBlock);
  tg_cut cut = line_cut();
  cut.size = offsetof(tg_cut, depth);
  cut.depth = cut.duration = std::numeric_limits<double>::quiet_NaN();
  ASSERT_EQ(tg_world_cut(block.world, &cut, nullptr), TG_OK) << tg_error();
  block.step(1);
  EXPECT_NEAR(block.measure("wounds.hand-1.depth_mm"), 10, 1e-9);
}

}  // namespace
}  // namespace turgor

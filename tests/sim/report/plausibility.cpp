#include "turgor/sim/report/plausibility.hpp"

#include <gtest/gtest.h>

#include "tests/sim/four_kinds.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

WorldSnapshot world_of(double size, Look look = Look::kFlesh) {
  BodySnapshot body;
  body.name = "liver", body.look = look;
  const auto s = Real(size);
  body.rest = {{0, 0, 0}, {s, 0, 0}, {0, s / 2, 0}};
  body.displacement.resize(3);
  body.triangles = {{0, 1, 2}};
  update_vertices(body);
  return {.time = 0, .frame = 0, .bodies = {body}, .tools = {}, .obstacles = {}};
}

// A body in millimeters that is read as meters causes a warning.
TEST(Plausibility, MillimetersReadAsMeters_Warns) {
  const std::vector<std::string> warnings = odd_sizes(world_of(180));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "liver: its size is 180 m, larger than the plausible 2 m: if its file is in millimeters, set "
            "scale = 0.001");
  EXPECT_EQ(odd_sizes(world_of(0.00018)).size(), 1u) << "also a body that was scaled twice";
  EXPECT_TRUE(odd_sizes(world_of(0.18)).empty());
}

// A tool larger than the body causes a warning.
TEST(Plausibility, ToolLargerThanBody_Warns) {
  WorldSnapshot snapshot = world_of(0.18);
  ToolSnapshot tool;
  tool.name = "finger", tool.size = 10;
  snapshot.tools = {tool};
  ASSERT_EQ(odd_sizes(snapshot).size(), 1u);
  EXPECT_NE(odd_sizes(snapshot)[0].find("finger: its contacting end has a size of 10 m"), std::string::npos);
  snapshot.tools[0].size = 0.01;
  EXPECT_TRUE(odd_sizes(snapshot).empty());
  snapshot.tools[0].size = 0.19;  // a ball of 0.11 m: the diagonal of its box
  EXPECT_TRUE(odd_sizes(snapshot).empty());
  snapshot.tools[0].size = 1, snapshot.tools[0].is_needle = true;
  EXPECT_TRUE(odd_sizes(snapshot).empty()) << "a needle may be longer than its body";
}

// Cloth stretched by more than half its length causes a warning with the time of the maximum.
TEST(Plausibility, OverstretchedCloth_Warns) {
  std::vector<ClothStretch> seen;
  WorldSnapshot snapshot = world_of(0.2, Look::kCloth);
  for (const Real pull : {1.2f, 1.7f, 1.4f}) {
    snapshot.time += 0.1;
    snapshot.bodies[0].displacement[1] = {0.2f * (pull - 1), 0, 0};
    update_vertices(snapshot.bodies[0]);
    record_stretch(snapshot, seen);
  }
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_NEAR(seen[0].most, 1.7, 1e-5);
  EXPECT_NEAR(seen[0].time, 0.2, 1e-12);
  EXPECT_EQ(overstretched(seen).size(), 1u);
  seen[0].most = 1.4;
  EXPECT_TRUE(overstretched(seen).empty());
}

/// Warnings of the world of four bodies with a press of the pad.
std::vector<std::string> warnings_of_press(std::vector<std::string> overrides) {
  overrides.emplace_back("output.video=false");
  const Scene scene = test::four_kinds_scene(test::fresh_folder(), overrides);
  Result<World> world = load_world(Exec(2), scene);
  EXPECT_TRUE(world) << world.error().message;
  const Result<Simulated> done = simulate(Exec(2), scene, *world);
  EXPECT_TRUE(done) << done.error().message;
  return overpressed(*world, done->measures.pressed);
}
constexpr const char *kGentle = "tool.finger.press.depth=0.001", *kDeep = "tool.finger.press.depth=0.012";

// A contact pressure above Young's modulus causes a warning; a gentle contact does not.
TEST(Plausibility, ContactAboveModulus_Warns) {
  EXPECT_TRUE(warnings_of_press({kGentle}).empty());
  const std::vector<std::string> warnings = warnings_of_press({kDeep});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("pad: the contact pressure was"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("(5 kPa)"), std::string::npos) << warnings[0];
}

// The modulus is that below the contact: a stiff sphere in a far corner, at the surface, changes nothing, and
// a stiff sphere below the finger bears the pressure. A factor of all stiffnesses changes both alike.
TEST(Plausibility, StiffSphere_CountsBelowContactOnly) {
  const auto sphere = [](const char* center) {
    return std::string("body.pad.inclusion.stone={ center_fraction = ") + center +
           ", radius = 0.009, young = 1e6 }";
  };
  const std::vector<std::string> far = warnings_of_press({kDeep, sphere("[1, 1, 1]")});
  ASSERT_EQ(far.size(), 1u);
  EXPECT_NE(far[0].find("(5 kPa)"), std::string::npos) << far[0];
  EXPECT_TRUE(warnings_of_press({kGentle, sphere("[0.3, 0.5, 1]")}).empty());
  EXPECT_TRUE(warnings_of_press({kGentle, "body.pad.stiffness_scale=10"}).empty());
}

}  // namespace
}  // namespace turgor

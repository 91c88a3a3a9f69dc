// Needles from a scene to a report, in recordings, and those that are refused.
#include "turgor/sim/bodies/sfem/needle_sfem.hpp"

#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/live/replayed_world.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "tests/sim/resumed.hpp"
#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/live/session.hpp"
#include "turgor/sim/report/page.hpp"
#include "turgor/sim/report/report_needle.hpp"
#include "turgor/sim/run.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

constexpr const char* kNeedleKeys = "needle = 0.06, diameter = 0.001";
constexpr const char* kNeedlePress =
    "press = { at = [0.031, 0.028, 0.04], depth = 0.025, start = 0, duration = 0.5, hold = 0.1, times = 2 }";

/// A block of 60 × 60 × 40 mm with a needle from above, and more tools or keys.
std::string needle_scene_text(const std::string& shape = kNeedleKeys,
                              const std::string& motion = kNeedlePress, const std::string& body = "",
                              const std::string& more = "") {
  return fmt::format(
      "[world]\nduration = 2.3\n[body.pad]\nmodel = \"sfem\"\n"
      "block = {{ size = [0.06, 0.06, 0.04], count = [6, 6, 4] }}\nfixed = \"bottom\"\nyoung = 4e3\n"
      "cache = false\n{}\n[tool.needle]\nbody = \"pad\"\nshape = {{ {} }}\n{}\n{}\n",
      body, shape, motion, more);
}

Result<World> needle_world(const Exec& exec, const std::string& text) {
  const Result<Scene> scene = parse_scene(text, test::fresh_folder() / "pad.toml");
  if (!scene) return scene.error();
  return load_world(exec, *scene);
}

World needle_run(int threads, const std::string& text) {
  Result<World> world = needle_world(Exec(threads), text);
  EXPECT_TRUE(world) << world.error().message;
  for (int frame = 0; world && frame < 138; frame++) EXPECT_TRUE(step(Exec(threads), *world));
  return std::move(*world);
}

// Two insertions: the report has one puncture, the longest insertion, and work that sums to the hand's.
TEST(NeedleSfem, ReportHasPunctureAndWork) {
  const World world = needle_run(1, needle_scene_text());
  const Json report = needle_report(world.tools[0], world.sfem_bodies[0]);
  EXPECT_EQ(report["punctures"], 1);
  EXPECT_NEAR(report["entry_force_N"].get<double>(), 0.328, 1e-6);
  EXPECT_GT(report["inserted_max_mm"].get<double>(), 19);
  EXPECT_LT(report["inserted_max_mm"].get<double>(), 25);
  EXPECT_LT(std::abs(report["work"]["error_percent"].get<double>()), 1);
  EXPECT_GT(report["work"]["cutting_mJ"].get<double>(), 2);
  ASSERT_GE(report["peaks"].size(), 2u);
  EXPECT_NEAR(report["peaks"][0][2].get<double>(), 0.328, 0.003);
  EXPECT_GT(report["series"].size(), 100u);
  // parts of the force at the deepest insertion
  double all = 0;
  const Json share = report["share"];
  for (const char* column : {"cutting_percent", "spreading_percent", "friction_percent"})
    all += share[column].get<double>();
  EXPECT_NEAR(all, 100, 0.1);
  const double inserted = report["inserted_max_mm"].get<double>() * 1e-3, friction = 1.4 * inserted;
  EXPECT_NEAR(share["friction_percent"].get<double>() / share["cutting_percent"].get<double>(),
              friction / 0.164, 0.1 * friction / 0.164);
  // the body is displaced by the needle while it is in
  EXPECT_EQ(world.sfem_bodies[0].needles.displacement.size(), 1u);
}

// A biopsy: a tough, stiff nodule on the path. The force rises to its toughness, the report says at which
// depth it begins and how far it was pushed, and the page marks it in the plot of the needle.
TEST(NeedleSfem, NoduleIsReachedAndItsMotionReported) {
  const double top = 0.04, center = 0.022, radius = 0.006;
  const World world = needle_run(
      1, needle_scene_text(kNeedleKeys, kNeedlePress,
                           fmt::format("inclusion = {{ nodule = {{ center = [0.031, 0.028, {}], radius = {}, "
                                       "young = 4e4, toughness = 400 }} }}\n",
                                       center, radius)));
  const Json report = needle_report(world.tools[0], world.sfem_bodies[0]);
  double in_nodule = 0;
  for (const ForceSample& s : world.tools[0].samples) in_nodule = std::max(in_nodule, s.needle.cutting);
  EXPECT_NEAR(in_nodule, 0.4, 1e-3) << "N";
  ASSERT_EQ(report["targets"].size(), 1u);
  EXPECT_EQ(report["targets"][0][0], "nodule");
  EXPECT_GT(report["targets"][0][1].get<double>(), 0.3) << "mm";
  EXPECT_LT(report["targets"][0][1].get<double>(), 6) << "mm";
  ASSERT_GE(report["layers"].size(), 1u) << report["layers"];
  EXPECT_EQ(report["layers"][0][0], "nodule");
  // it is pushed ahead of the tip, and elements of 10 mm resolve it
  EXPECT_NEAR(report["layers"][0][3].get<double>(), 1e3 * (top - center - radius), 8) << report["layers"];
  const Json tool{{"name", "needle"}, {"needle", report}};
  const std::string page = page::touch_curves({{"tools", Json::array({tool})}});
  EXPECT_NE(page.find("Needle needle"), std::string::npos);
  EXPECT_NE(page.find("nodule"), std::string::npos);
}

// A state file keeps a needle inside of the body: the resumed world has the same bits.
TEST(NeedleSfem, StateIsRestored) {
  const std::filesystem::path folder = test::fresh_folder();
  const Exec exec(1);
  Result<World> world = needle_world(exec, needle_scene_text()),
                resumed = needle_world(exec, needle_scene_text());
  ASSERT_TRUE(world && resumed);
  const LoadedPatches loaded = loaded_patches(*world);
  for (int frame = 0; frame < 24; frame++) ASSERT_TRUE(step(exec, *world));
  ASSERT_EQ(world->sfem_bodies[0].touch.needles.needles[0].phase, contact::NeedlePhase::kInside);
  test::expect_resumes(exec, folder / "state", loaded, *world, *resumed);
  EXPECT_EQ(resumed->sfem_bodies[0].touch.needles.needles[0].force,
            world->sfem_bodies[0].touch.needles.needles[0].force);
}

// A needle that bends deflects toward the edge of its bevel; the report says by how much. The same bits on
// any number of threads.
TEST(NeedleSfem, BevelDeflectsAndIsReported) {
  const std::string shape = "needle = 0.06, diameter = 0.0005, bends = true, bevel = 25, bevel_toward = 90";
  const World one = needle_run(1, needle_scene_text(shape)), three = needle_run(3, needle_scene_text(shape));
  EXPECT_EQ(state_hash(one), state_hash(three));
  const Json report = needle_report(one.tools[0], one.sfem_bodies[0]);
  EXPECT_NEAR(report["bending_stiffness_N_m2"].get<double>(),
              2e11 * 3.14159 / 64 * 0.0005 * 0.0005 * 0.0005 * 0.0005, 1e-6);
  const double deepest = report["deflection_deepest_mm"].get<double>();
  EXPECT_GT(deepest, 0.05);
  EXPECT_GE(report["deflection_max_mm"].get<double>(), deepest);
  // toward the tool's y axis
  Vec3d most;
  for (const ForceSample& s : one.tools[0].samples)
    if (s.needle.inserted > 0.018) most = s.needle.deflection;
  EXPECT_GT(dot(most, one.tools[0].samples[0].axes.column[1]), 0.8 * norm(most));
  EXPECT_FALSE(needle_report(needle_run(1, needle_scene_text()).tools[0], one.sfem_bodies[0])
                   .contains("deflection_max_mm"));
}

// The same bits on any number of threads, also beside a finger, which the needle feels.
TEST(NeedleSfem, ThreadsKeepBitsBesideFinger) {
  const std::string finger =
      "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\npress = { at = [0.045, 0.028, "
      "0.04], depth = 0.005, start = 0.6, duration = 0.1, hold = 0.1 }\n";
  const std::string text = needle_scene_text(kNeedleKeys, kNeedlePress, "", finger);
  const World one = needle_run(1, text), three = needle_run(3, text);
  EXPECT_EQ(state_hash(one), state_hash(three));
  const World alone = needle_run(1, needle_scene_text());
  double most = 0;
  for (std::size_t i = 650; i < 800; i++)
    most = std::max(most, norm(one.tools[0].samples[i].force - alone.tools[0].samples[i].force));
  EXPECT_GT(most, 1e-3) << "the finger moves the tissue around the needle";
  // the work on the finger is a part of the balance
  const Json work = needle_report(one.tools[0], one.sfem_bodies[0])["work"];
  EXPECT_LT(std::abs(work["error_percent"].get<double>()), 2);
  EXPECT_NE(work["others_mJ"].get<double>(), 0);
}

// New Green's functions keep the motion of the tissue by a finger at rest: the force on a needle at rest
// stays.
TEST(NeedleSfem, NewElementsKeepForceBesideFinger) {
  const std::string deep =
      "press = { at = [0.031, 0.028, 0.04], depth = 0.02, start = 0, duration = 0.3, hold = 2 }";
  const std::string finger =
      "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\npress = { at = [0.046, 0.028, 0.04], "
      "depth = 0.005, start = 0.4, duration = 0.2, hold = 2 }\n";
  const Exec exec(1);
  Result<World> world = needle_world(exec, needle_scene_text(kNeedleKeys, deep, "", finger));
  ASSERT_TRUE(world) << world.error().message;
  for (int frame = 0; frame < 90; frame++) ASSERT_TRUE(step(exec, *world));
  SfemBody& body = world->sfem_bodies[0];
  ASSERT_GT(norm(world->tools[1].samples[world->tools[1].samples.size() - 1].force), 0.05) << "N";
  const std::size_t last = world->tools[0].samples.size() - 1;
  const Vec3d before = world->tools[0].samples[last].force;
  ASSERT_LT(norm(before - world->tools[0].samples[last - 20].force), 1e-6 * norm(before)) << "at rest";
  // all elements of the body
  std::vector<int> all;
  for (std::size_t e = 0; e < element_count(body.model.body.mesh); e++) all.push_back(int(e));
  ASSERT_LT(body.needles.inner->elements.size(), all.size());
  sfem::InnerGreen inner = sfem::make_inner_green(exec, body.model, all);
  for (const int material : inner.material) inner.toughness.push_back(body.toughness[std::size_t(material)]);
  body.needles.inner = std::make_shared<const sfem::InnerGreen>(std::move(inner));
  body.needles.in_use.push_back(body.needles.inner);
  displace_by_needles(body);
  ASSERT_TRUE(step(exec, *world));
  ASSERT_EQ(body.touch.needles.inner->elements.size(), all.size());
  for (std::size_t i = last + 1; i < world->tools[0].samples.size(); i++)
    EXPECT_LT(norm(world->tools[0].samples[i].force - before), 1e-6 * norm(before)) << i - last;
}

// A needle enters a body where it is: springs let this one sink sideways by 20 mm of its width of 60 mm under
// its weight.
TEST(NeedleSfem, EntersBodyThatHasMoved) {
  constexpr double kGravity = 9.81, kAside = 0.02;
  const double weight = 0.06 * 0.06 * 0.04 * 1050 * kGravity;
  const std::string text = fmt::format(
      "[world]\nduration = 3\ngravity = [{}, 0, 0]\n[body.pad]\nmodel = \"sfem\"\nblock = {{ size = [0.06, "
      "0.06, 0.04], count = [6, 6, 4] }}\nfixed = \"none\"\ndensity = 1050\nyoung = 2e4\ncache = false\n"
      "[attachment.nest]\nbetween = [\"pad\", \"ground\"]\nbox = [[-1, -1, -1], [1, 1, 1]]\nstiffness = "
      "{}\n[tool.needle]\nbody = \"pad\"\nshape = {{ {} }}\npath = [[0, 0.051, 0.028, 0.05], [2, 0.051, "
      "0.028, "
      "0.05], [2.5, 0.051, 0.028, 0.015], [3, 0.051, 0.028, 0.015]]\n",
      kGravity, weight / kAside, kNeedleKeys);
  Result<World> world = needle_world(Exec(1), text);
  ASSERT_TRUE(world) << world.error().message;
  while (time_of(*world) < 1.99) ASSERT_TRUE(step(Exec(1), *world));
  const SfemBody& body = world->sfem_bodies[0];
  Vec3d moved;
  for (const Vec3d u : body.flight->u) moved += u / double(body.flight->u.size());
  EXPECT_NEAR(moved.x, kAside, 0.1 * kAside);
  while (time_of(*world) < 2.99) ASSERT_TRUE(step(Exec(1), *world));
  const Json report = needle_report(world->tools[0], body);
  EXPECT_EQ(report["punctures"], 1);
  EXPECT_NEAR(report["entry_force_N"].get<double>(), 0.328, 1e-6);
  EXPECT_GT(report["inserted_max_mm"].get<double>(), 10);
}

// The hole that a needle has left stays while the needle enters 50 mm away, and is entered again without
// cutting.
TEST(NeedleSfem, HolesStayWhileNeedleIsElsewhere) {
  constexpr double kPause = 0.2;  // after the path, before the end [s]
  const std::string text = fmt::format(
      "[world]\nduration = 3.2\n[body.pad]\nmodel = \"sfem\"\nblock = {{ size = [0.1, 0.04, 0.05], count = "
      "[10, "
      "4, 5] }}\nfixed = \"bottom\"\nyoung = 4e3\ncache = false\n[tool.needle]\nbody = \"pad\"\nshape = {{ "
      "{} "
      "}}\npath = [[0, 0.025, 0.02, 0.052], [0.5, 0.025, 0.02, 0.032], [1, 0.025, 0.02, 0.056], [1.3, 0.075, "
      "0.02, "
      "0.056], [1.6, 0.075, 0.02, 0.04], [1.9, 0.075, 0.02, 0.056], [2.2, 0.025, 0.02, 0.056], [3, 0.025, "
      "0.02, "
      "0.036]]\n",
      kNeedleKeys);
  Result<World> world = needle_world(Exec(1), text);
  ASSERT_TRUE(world) << world.error().message;
  while (time_of(*world) < 3 + kPause / 2) ASSERT_TRUE(step(Exec(1), *world));
  const Json report = needle_report(world->tools[0], world->sfem_bodies[0]);
  EXPECT_EQ(report["punctures"], 2);
  const auto& samples = world->tools[0].samples;
  double cutting = 0;
  for (std::size_t i = 2300; i < samples.size(); i++) cutting = std::max(cutting, samples[i].needle.cutting);
  EXPECT_LT(cutting, 0.01) << "N, in the first hole again";
}

// A needle leaves a plate by its far surface at the surface's own toughness, also where it passes beside the
// centers of elements.
TEST(NeedleSfem, FarSurfaceHoldsTipAnywhere) {
  constexpr double kExit = 500, kDiameter = 0.001;  // [J/m²] [m]
  for (const double x : {0.031, 0.033, 0.035, 0.0385}) {
    const std::string text = fmt::format(
        "[world]\nduration = 1\n[body.plate]\nmodel = \"sfem\"\nblock = {{ size = [0.06, 0.04, 0.03], count "
        "= "
        "[6, 4, 3] }}\nfixed = {{ sides = [\"left\", \"right\"] }}\nyoung = 4e3\ncache = "
        "false\n[tool.needle]\n"
        "body = \"plate\"\nshape = {{ needle = 0.09, diameter = {}, exit_toughness = {} }}\npath = [[0, {x}, "
        "0.021, "
        "0.032], [0.4, {x}, 0.021, 0.01], [0.8, {x}, 0.021, -0.03]]\n",
        kDiameter, kExit, fmt::arg("x", x));
    Result<World> world = needle_world(Exec(1), text);
    ASSERT_TRUE(world) << world.error().message;
    while (time_of(*world) < 0.9) ASSERT_TRUE(step(Exec(1), *world));
    double at_exit = 0;
    bool is_beyond = false;
    for (const ForceSample& s : world->tools[0].samples) {
      at_exit = std::max(at_exit, s.needle.cutting);
      is_beyond = is_beyond || s.beyond_patch;
    }
    EXPECT_NEAR(at_exit, kExit * kDiameter, 0.02 * kExit * kDiameter) << "N at " << x;
    EXPECT_FALSE(is_beyond) << x;
  }
}

// Two needles 10 mm apart in one body: each punctures it, the one at rest feels the one that enters, and the
// bits do not depend on the number of threads.
TEST(NeedleSfem, TwoNeedlesActOnEachOther) {
  const std::string once =
      "press = { at = [0.031, 0.028, 0.04], depth = 0.02, start = 0, duration = 0.5, hold = 1.5 }";
  const std::string second =
      "[tool.second]\nbody = \"pad\"\nshape = { needle = 0.06, diameter = 0.001 }\npress = { at = [0.041, "
      "0.028, "
      "0.04], depth = 0.015, start = 0.8, duration = 0.5, hold = 0.5 }\n";
  const std::string text = needle_scene_text(kNeedleKeys, once, "", second);
  const World both = needle_run(1, text), three = needle_run(3, text);
  EXPECT_EQ(state_hash(both), state_hash(three));
  for (const TouchingTool& tool : both.tools) {
    const Json report = needle_report(tool, both.sfem_bodies[0]);
    EXPECT_EQ(report["punctures"], 1);
    EXPECT_NEAR(report["peaks"][0][2].get<double>(), 0.328, 0.01) << "N: force of entry";
    EXPECT_LT(std::abs(report["work"]["error_percent"].get<double>()), 1);
  }
  const World alone = needle_run(1, needle_scene_text(kNeedleKeys, once));
  double before = 0, most = 0;
  for (std::size_t i = 600; i < 1300; i++) {
    const double apart = norm(both.tools[0].samples[i].force - alone.tools[0].samples[i].force);
    double& largest = i < 790 ? before : most;
    largest = std::max(largest, apart);
  }
  EXPECT_EQ(before, 0) << "N: the second needle is not in yet";
  EXPECT_GT(most, 1e-3) << "N: the second needle moves the tissue around the first";
}

// A needle that a mouse moves in a live session, also away from its path, replays to the same bits.
TEST(NeedleSfem, LiveNeedleReplaysExactly) {
  const auto folder = test::fresh_folder();
  std::ofstream(folder / "pad.toml") << needle_scene_text();
  Session session(folder / "pad.toml", {}, test::kOneThread);
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  const auto advance = [&](double time) {
    const double begin = session.now().snapshot.time;
    ASSERT_TRUE(test::wait_until(session,
                                 [&](const SessionStatus& now) { return now.snapshot.time > begin + time; }));
  };
  // the second hole is beyond the elements along the scripted path
  int teleports = 0;
  for (const double x : {0.031, 0.052}) {
    teleports++;
    for (const double depth : {-0.003, 0.02, 0.012, 0.024, -0.003}) {
      session.now().mouse.at(0).device->set_target({.pose = {{x, 0.028, 0.04 - depth}, {}},
                                                    .hold = false,
                                                    .teleports = teleports,
                                                    .teleport_to = {x, 0.028, 0.043}});
      advance(0.12);
    }
  }
  session.request(SaveRequest{folder / "haptic.h5"});
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) { return !now.saved.empty(); }));
  const Result<HapticRecording> run = read_haptic_recording(folder / "haptic.h5");
  ASSERT_TRUE(run) << session.now().saved;
  const World world = test::replayed_world(*run, 2);
  EXPECT_EQ(state_hash(world), run->hash);
  EXPECT_EQ(world.sfem_bodies[0].touch.needles.needles[0].punctures, 2);
  EXPECT_FALSE(world.sfem_bodies[0].touch.needles.needles[0].beyond);
}

// Needles that the models cannot have are refused with a sentence.
TEST(NeedleSfem, RefusesWrongNeedles) {
  const std::string path = "path = [[0, 0.031, 0.028, 0.03], [1, 0.031, 0.028, 0.01]]";
  const std::string deep = "press = { at = [0.031, 0.028, 0.04], depth = 0.035 }";
  const std::string cloth =
      "[world]\n[body.s]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, 0], side = [0.1, 0, 0], up = [0, 0.1, "
      "0], columns "
      "= 4, rows = 4 }\nfabric = { law = \"sheet\" }\nsolver = { method = \"two_level\" "
      "}\n[tool.needle]\nbody = "
      "\"s\"\nshape = { needle = 0.06 }\npress = { at_fraction = [0.5, 0.5, 1] }\n";
  const std::pair<std::string, const char*> cases[] = {
      {needle_scene_text(kNeedleKeys, path),
       "expected a needle that starts outside of pad, found its tip 0.01 m below"},
      {needle_scene_text("needle = 0.03", deep),
       "expected a path into pad of at most the needle's length, 0.03 m"},
      {needle_scene_text("needle = 0.06, diameter = 0"), "diameter: expected a number between 0 and 0.01"},
      {needle_scene_text("needle = 0.4"), "needle: expected a number between 0 and 0.3"},
      {needle_scene_text("needle = 0.29, spacing = 0.0002"),
       "expected at most 240 points along a needle, found 1452"},
      {needle_scene_text("needle = 0.06, bevel = 30"),
       "bevel: expected bends = true beside bevel: a rigid needle does not follow it"},
      {needle_scene_text("needle = 0.06, bends = true, bevel = 3"), "bevel: expected a number from 5 to 90"},
      {needle_scene_text("needle = 0.06, sphere = 0.01"),
       "a tool has one shape: either sphere or needle, not both"},
      {needle_scene_text(kNeedleKeys, kNeedlePress, "viscosity = { ratio = 1, time = 0.5 }"),
       "a needle needs an elastic body, found viscosity"},
      {cloth, "expected a body with model = \"sfem\" or \"lattice\" for a needle, found model = \"cloth\""},
  };
  for (const auto& [text, words] : cases) {
    const Result<World> world = needle_world(Exec(1), text);
    ASSERT_FALSE(world) << words;
    EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message << "\n" << words;
  }
}

}  // namespace
}  // namespace turgor

// Needles in lattice bodies from a scene to a report, in state files and live sessions, and those refused.
#include "turgor/sim/bodies/lattice/needle_lattice.hpp"

#include <cmath>
#include <fstream>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/live/replayed_world.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "tests/sim/resumed.hpp"
#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/live/session.hpp"
#include "turgor/sim/report/report_needle.hpp"
#include "turgor/sim/run.hpp"
#include "turgor/sim/tools/tool_path.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

/// 24 mm of fat above 40 mm of muscle; the front is at y = 0.
CtVolume needle_ct() {
  return test::layered_ct({.size = {24, 20, 24},
                           .air = {3, 2, 3},
                           .origin = {-0.046, -0.006, -0.046},
                           .deep_from = 8,
                           .deep = 60});
}

constexpr const char* kNeedleShape =
    "needle = 0.06, diameter = 0.001, toughness = 60, entry_toughness = 120, shaft_friction = 1.4, spreading "
    "= "
    "2e4";
constexpr const char* kNeedleInOut =
    "press = { at = [0.005, -0.01, 0.003], depth = 0.036, start = 0, duration = 1, hold = 0.1, times = 2 }";
constexpr const char* kOrganLayer =
    "inside = { organ = { hu = [0, 120], toughness = 140, shaft_friction = 2 } }\n";

std::string needle_text(const std::string& shape = kNeedleShape, const std::string& motion = kNeedleInOut,
                        const std::string& body = kOrganLayer, const std::string& more = "") {
  return fmt::format(
      "[world]\nduration = 4.2\nframe_rate = 60\n[body.pad]\nmodel = \"lattice\"\nct = \"pad.nii\"\nblock = "
      "1\n"
      "skin = false\ngravity = false\nfixed = {{ sides = \"back\" }}\ntissue = {{ young = 1e4 "
      "}}\n{}\n[tool.needle]\nbody "
      "= "
      "\"pad\"\nshape = {{ {} }}\n{}\n{}\n",
      body, shape, motion, more);
}

Result<World> lattice_needle_world(const Exec& exec, const std::string& text) {
  const auto folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "pad.nii", needle_ct()));
  const Result<Scene> scene = parse_scene(text, folder / "pad.toml");
  if (!scene) return scene.error();
  return load_world(exec, *scene);
}

World lattice_needle_run(int threads, const std::string& text, int frames) {
  Result<World> world = lattice_needle_world(Exec(threads), text);
  EXPECT_TRUE(world) << world.error().message;
  for (int frame = 0; world && frame < frames; frame++) EXPECT_TRUE(step(Exec(threads), *world));
  return std::move(*world);
}

/// Toughness at a depth below the front of the block [J/m²].
double toughness_at(const LatticeBody& body, double depth) {
  const Grid& grid = body.model.anatomy.grid;
  return needle_tissue(body, inverse(grid.axes) * (Vec3d{0, depth, 0} - grid.origin)).toughness;
}

// Layers of the tissue's law have their own toughness: by depth, where no region by CT value has one, and not
// in bone. `inside` comes first.
TEST(NeedleLattice, LayersHaveTheirToughness) {
  const std::string layers =
      "layers = [{ name = \"skin\", thickness = 0.008, young = 1e4 }, { name = \"organ\", hu = [0, 120], "
      "young = "
      "1e4, toughness = 140 }, { name = \"fat\", young = 1e4, toughness = 70 }]\n";
  const World world = lattice_needle_world(Exec(1), needle_text(kNeedleShape, kNeedleInOut, layers)).value();
  const LatticeBody& body = world.lattice_bodies[0];
  EXPECT_EQ(toughness_at(body, 0.004), kNeedlesOwn);
  EXPECT_EQ(toughness_at(body, 0.016), 70);
  EXPECT_EQ(toughness_at(body, 0.04), 140);
  // needles' own layers, and bone
  const World both =
      lattice_needle_world(Exec(1), needle_text(kNeedleShape, kNeedleInOut,
                                                layers + "inside.near = { depth = 0.012, toughness = 9 }\n"))
          .value();
  EXPECT_EQ(toughness_at(both.lattice_bodies[0], 0.004), 9);
  EXPECT_EQ(toughness_at(both.lattice_bodies[0], 0.016), 70);
  LatticeBody bone = both.lattice_bodies[0];
  bone.model.params.tissue.bone_min = 50;
  std::erase_if(bone.layers.layers, [](const NeedleLayerScene& layer) { return layer.hu.has_value(); });
  EXPECT_EQ(toughness_at(bone, 0.04), std::numeric_limits<double>::infinity());
}

// Two insertions through fat into muscle: one puncture, the depth at which the layer begins, its toughness,
// work that sums to the hand's, and the motion of the layer.
TEST(NeedleLattice, ReportHasPunctureLayersAndWork) {
  const World world = lattice_needle_run(1, needle_text(), 252);
  const Json report = needle_report(world.tools[0], world.lattice_bodies[0]);
  EXPECT_EQ(report["punctures"], 1);
  EXPECT_NEAR(report["entry_force_N"].get<double>(), 0.12, 1e-6);
  EXPECT_GT(report["inserted_max_mm"].get<double>(), 33);
  EXPECT_LT(std::abs(report["work"]["error_percent"].get<double>()), 4);
  EXPECT_NEAR(report["peaks"][0][2].get<double>(), 0.12, 0.01);
  ASSERT_EQ(report["layers"].size(), 2u) << report["layers"];
  for (const Json& passage : report["layers"]) EXPECT_NEAR(passage[3].get<double>(), 24, 4) << passage;
  EXPECT_EQ(report["layers"][0][0], "organ");
  EXPECT_GT(report["targets"][0][1].get<double>(), 0.01);
  double fat = 0, organ = 0;
  for (const ForceSample& s : world.tools[0].samples) {
    if (s.time < 1 && s.needle.inserted > 0.012 && s.needle.inserted < 0.016) fat = s.needle.cutting;
    organ = std::max(organ, s.needle.inserted > 0 ? s.needle.cutting : 0);
  }
  EXPECT_NEAR(fat, 0.06, 1e-6);
  EXPECT_NEAR(organ, 0.14, 1e-6);
}

// Friction along the shaft is that of the layer: f per length rises by the layer's shaft_friction where the
// shaft goes on into it, and by the needle's own above.
TEST(NeedleLattice, FrictionIsThatOfTheLayer) {
  const std::string once =
      "press = { at = [0.005, -0.01, 0.003], depth = 0.036, start = 0, duration = 2, hold = 0.1 }";
  const World world = lattice_needle_run(1, needle_text(kNeedleShape, once), 120);
  // slope of the friction between two lengths of the shaft in the tissue [N/m]
  const auto slope = [&](double from, double to) {
    const ForceSample *first = nullptr, *last = nullptr;
    for (const ForceSample& s : world.tools[0].samples) {
      if (s.needle.inserted < from || s.needle.inserted > to) continue;
      first = first ? first : &s, last = &s;
    }
    if (!first || first == last) return 0.0;
    return (last->needle.friction - first->needle.friction) /
           (last->needle.inserted - first->needle.inserted);
  };
  const double fat = slope(0.010, 0.020), organ = slope(0.030, 0.034);
  EXPECT_NEAR(fat, 1.4, 0.1);
  EXPECT_NEAR(organ, 2, 0.1);
}

/// Mean force along a needle, and its parts, between two lengths of the shaft in the tissue during insertion.
struct MeanForce {
  double whole = 0, friction = 0;
};
MeanForce mean_force(const TouchingTool& tool, double from, double to) {
  MeanForce mean;
  int count = 0;
  double before = 0;
  for (const ForceSample& s : tool.samples) {
    const bool goes_in = s.needle.inserted > before;
    before = s.needle.inserted;
    if (!goes_in || before < from || before > to) continue;
    mean.whole += dot(s.force, s.axes.column[2]), mean.friction += s.needle.friction, count++;
  }
  EXPECT_GT(count, 5);
  return {mean.whole / count, mean.friction / count};
}

// The same block of one tissue as a lattice and of finite elements: the same needle has the same force.
TEST(NeedleLattice, FeelsLikeNeedleInSfem) {
  const std::string press = "depth = 0.03, start = 0, duration = 1, hold = 0.1 }";
  const World lattice = lattice_needle_run(
      1, needle_text(kNeedleShape, "press = { at = [0.005, -0.01, 0.003], " + press, ""), 60);
  const std::string text = fmt::format(
      "[world]\nduration = 1\nframe_rate = 60\n[body.pad]\nmodel = \"sfem\"\nblock = {{ size = [0.072, "
      "0.072, "
      "0.064], count = [9, 9, 8] }}\nfixed = \"bottom\"\nyoung = 1e4\npoisson = 0.45\ncache = "
      "false\n[tool.needle]\nbody = \"pad\"\nshape = {{ {} }}\npress = {{ at = [0.041, 0.037, 0.07], {}\n",
      kNeedleShape, press);
  const Result<Scene> scene = parse_scene(text, test::fresh_folder() / "pad.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  Result<World> sfem = load_world(Exec(1), *scene);
  ASSERT_TRUE(sfem) << sfem.error().message;
  for (int frame = 0; frame < 60; frame++) ASSERT_TRUE(step(Exec(1), *sfem));
  const TouchingTool &a = lattice.tools[0], &b = sfem->tools[0];
  const MeanForce in_lattice = mean_force(a, 0.012, 0.024), in_sfem = mean_force(b, 0.012, 0.024);
  std::printf("lattice %.4f N, friction %.4f N; sfem %.4f N, friction %.4f N; work %.3f and %.3f mJ\n",
              in_lattice.whole, in_lattice.friction, in_sfem.whole, in_sfem.friction,
              a.needle_work.hand * 1e3, b.needle_work.hand * 1e3);
  EXPECT_NEAR(a.entry_force, b.entry_force, 1e-3 * b.entry_force);
  EXPECT_NEAR(in_lattice.whole, in_sfem.whole, 0.05 * in_sfem.whole);
  EXPECT_NEAR(in_lattice.friction, in_sfem.friction, 0.05 * in_sfem.friction);
}

// Two needles and a finger in one body: the same bits on any number of threads, and the second needle moves
// the first.
TEST(NeedleLattice, ThreadsKeepBitsWithTwoNeedles) {
  const std::string others = fmt::format(
      "[tool.second]\nbody = \"pad\"\nshape = {{ {} }}\npress = {{ at = [-0.006, -0.01, 0.003], depth "
      "= 0.02, duration = 0.5 }}\n[tool.finger]\nbody = \"pad\"\nshape = {{ sphere = 0.006 }}\npress = "
      "{{ at = [0.02, -0.01, -0.01], depth = 0.004, duration = 0.4 }}\n",
      kNeedleShape);
  const std::string text = needle_text(kNeedleShape, kNeedleInOut, kOrganLayer, others);
  const World one = lattice_needle_run(1, text, 40), three = lattice_needle_run(3, text, 40);
  EXPECT_EQ(state_hash(one), state_hash(three));
  EXPECT_EQ(one.tools[1].punctures, 1);
  const World alone = lattice_needle_run(1, needle_text(), 40);
  double most = 0;
  for (std::size_t i = 20; i < 40; i++)
    most = std::max(most, norm(one.tools[0].samples[i].force - alone.tools[0].samples[i].force));
  EXPECT_GT(most, 1e-3);
}

// A state file keeps a needle inside of the body: the resumed world has the same bits.
TEST(NeedleLattice, StateIsRestored) {
  const std::filesystem::path folder = test::fresh_folder();
  const Exec exec(1);
  Result<World> world = lattice_needle_world(exec, needle_text()),
                resumed = lattice_needle_world(exec, needle_text());
  ASSERT_TRUE(world && resumed);
  const LoadedPatches loaded = loaded_patches(*world);
  for (int frame = 0; frame < 45; frame++) ASSERT_TRUE(step(exec, *world));
  ASSERT_EQ(world->lattice_bodies[0].needles[0].phase, contact::NeedlePhase::kInside);
  test::expect_resumes(exec, folder / "state", loaded, *world, *resumed);
  EXPECT_EQ(resumed->lattice_bodies[0].needles[0].force, world->lattice_bodies[0].needles[0].force);
}

// A needle that a mouse moves in a live session replays to the same bits, and its log has its work.
TEST(NeedleLattice, LiveNeedleReplaysExactly) {
  const auto folder = test::fresh_folder();
  ASSERT_TRUE(write_ct(folder / "pad.nii", needle_ct()));
  std::ofstream(folder / "pad.toml") << needle_text();
  Session session(folder / "pad.toml", {}, test::kOneThread);
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  const Mat3d axes = axes_of(turned_to({0, -1, 0}));
  for (const double depth : {-0.003, 0.02, 0.012, 0.024, -0.003}) {
    session.now().mouse.at(0).device->set_target({.pose = {{0.005, depth, 0.003}, axes},
                                                  .hold = false,
                                                  .teleports = 1,
                                                  .teleport_to = {0.005, -0.003, 0.003}});
    const double begin = session.now().snapshot.time;
    ASSERT_TRUE(test::wait_until(session,
                                 [&](const SessionStatus& now) { return now.snapshot.time > begin + 0.15; }));
  }
  session.request(SaveRequest{folder / "haptic.h5"});
  ASSERT_TRUE(test::wait_until(session, [](const SessionStatus& now) { return !now.saved.empty(); }));
  const Result<HapticRecording> run = read_haptic_recording(folder / "haptic.h5");
  ASSERT_TRUE(run) << session.now().saved;
  const World world = test::replayed_world(*run, 2);
  EXPECT_EQ(state_hash(world), run->hash);
}

// Needles that a lattice cannot have are refused with a sentence.
TEST(NeedleLattice, RefusesWrongNeedles) {
  const std::string inside = "path = [[0, 0, 0.021, 0], [1, 0, 0.03, 0]]";
  const std::string springs = needle_text(kNeedleShape, kNeedleInOut, "solver = { sweeps = 8 }");
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::pair<std::string, const char*> cases[] = {
      {needle_text(kNeedleShape, inside), "expected a needle that starts outside of pad, found its tip 0.02"},
      {needle_text("needle = 0.02"), "expected a path into pad of at most the needle's length, 0.02 m"},
      {replaced(springs, "young = 1e4", "young = 1e4, law = \"springs\""),
       "for a needle, found \"springs\" in pad: springs have no modulus around a shaft"},
      {replaced(springs, "frame_rate", "device = \"gpu\"\nframe_rate"),
       "expected world.device = \"cpu\" for a needle in a lattice, found \"gpu\""},
      {replaced(springs, "sweeps = 8", "method = \"pbd\""), "which has no contact forces in newtons"},
      {needle_text(kNeedleShape, kNeedleInOut, "inside = { a = { label = 3 } }"),
       "a layer by label needs a segmentation"},
      {needle_text(kNeedleShape, kNeedleInOut, "inside = { a = { hu = [0, 50], depth = 0.01 } }"),
       "a layer has one of label, hu and depth"},
      {needle_text(kNeedleShape, kNeedleInOut, "inside = { a = { hu = [0, 50] }, b = { hu = [40, 90] } }"),
       "the range overlaps that of a: expected each HU in one layer"},
      {needle_text(kNeedleShape, kNeedleInOut, "inside = { a = { hu = [50, 0] } }"),
       "[from, to] with from < to [HU]"},
      {needle_text(kNeedleShape, kNeedleInOut, "inside = { a = { toughness = 3 } }"), "which tissue it is"},
  };
  for (const auto& [text, words] : cases) {
    const Result<World> world = lattice_needle_world(Exec(1), text);
    ASSERT_FALSE(world) << words;
    EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message << "\n" << words;
  }
}

}  // namespace
}  // namespace turgor

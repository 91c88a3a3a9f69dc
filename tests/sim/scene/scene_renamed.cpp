// Old names of scene keys and values: they are read as the current ones, and each use adds a note.
#include "turgor/sim/scene/scene_renamed.hpp"

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_edit.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

const std::string kLatticeBody = "[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"torso\" }\n";
const std::string kClothBody =
    "[body.flag]\nmodel = \"cloth\"\nsheet = { side = [1, 0, 0], up = [0, 0, 1] }\n";
const std::string kSolidBody =
    "[body.pad]\nmodel = \"sfem\"\nblock = { size = [1, 1, 1], count = [1, 1, 1] }\n";
const std::string kUntil = "; the old name is read until the next release";

Scene read_renamed(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const Result<Scene> scene = parse_scene(text, "s.toml", overrides);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  return scene ? *scene : Scene{};
}

// Old keys of lattice bodies set the current fields, each with a note.
TEST(SceneRenamed, OldKeysOfLatticesAreRead) {
  const Scene scene =
      read_renamed(kLatticeBody + "step = 0.004\nsolver = { schedule = \"colors\", sleep = 3e-4 }\n");
  const LatticeScene& body = scene.lattice_bodies.at(0);
  EXPECT_EQ(body.spacing, 0.004);
  EXPECT_EQ(body.params.solver.ordering, lattice::Ordering::kColors);
  EXPECT_EQ(body.params.solver.sleep_speed, 3e-4);
  EXPECT_EQ(scene.notes,
            (std::vector<std::string>{"body.torso: key \"step\" is now \"spacing\"" + kUntil,
                                      "body.torso.solver: key \"schedule\" is now \"ordering\"" + kUntil,
                                      "body.torso.solver: key \"sleep\" is now \"sleep_speed\"" + kUntil}));
}

// Old keys of inclusions set the current fields, each with a note.
TEST(SceneRenamed, OldKeysOfInclusionsAreRead) {
  const Scene scene = read_renamed(kSolidBody +
                                   "inclusion.a = { centre = [0.1, 0.2, 0.3] }\n"
                                   "inclusion.b = { centre_fraction = [0.5, 0.6, 0.7] }\n");
  const SfemScene& body = scene.sfem_bodies.at(0);
  EXPECT_EQ(body.inclusions.at(0).center, (Vec3d{0.1, 0.2, 0.3}));
  EXPECT_FALSE(body.inclusions.at(0).by_fraction);
  EXPECT_EQ(body.inclusions.at(1).center, (Vec3d{0.5, 0.6, 0.7}));
  EXPECT_TRUE(body.inclusions.at(1).by_fraction);
  EXPECT_EQ(scene.notes,
            (std::vector<std::string>{
                "body.pad.inclusion.a: key \"centre\" is now \"center\"" + kUntil,
                "body.pad.inclusion.b: key \"centre_fraction\" is now \"center_fraction\"" + kUntil}));
}

// Old keys of cloth set the current fields, each with a note.
TEST(SceneRenamed, OldKeysOfClothAreRead) {
  const Scene scene = read_renamed(kClothBody +
                                   "hold.corner.ball = { centre = [0.1, 0, 0], radius = 0.02 }\n"
                                   "obstacle.peg.sphere = { centre = [0.2, 0, 0], radius = 0.03 }\n");
  const ClothScene& body = scene.cloth_bodies.at(0);
  EXPECT_EQ(body.holds.at(0).ball->center, (Vec3d{0.1, 0, 0}));
  EXPECT_EQ(std::get<BallScene>(body.obstacles.at(0).shape).center, (Vec3d{0.2, 0, 0}));
  EXPECT_EQ(scene.notes, (std::vector<std::string>{
                             "body.flag.hold.corner.ball: key \"centre\" is now \"center\"" + kUntil,
                             "body.flag.obstacle.peg.sphere: key \"centre\" is now \"center\"" + kUntil}));
}

// Old values of keys are read as the current ones, each with a note.
TEST(SceneRenamed, OldValuesAreRead) {
  const Scene scene = read_renamed(
      kLatticeBody + "skin.law = \"fibre\"\nsolver = { method = \"descent\", ordering = \"colours\" }\n" +
      kClothBody + "solver.method = \"blocks\"\n");
  const lattice::Params& params = scene.lattice_bodies.at(0).params;
  EXPECT_EQ(params.solver.method, lattice::Method::kVbd);
  EXPECT_EQ(params.solver.ordering, lattice::Ordering::kColors);
  EXPECT_EQ(params.skin.law, lattice::SkinLaw::kFiber);
  EXPECT_EQ(scene.cloth_bodies.at(0).params.solver.method, cloth::Method::kTwoLevel);
  std::vector<std::string> notes = scene.notes;
  std::sort(notes.begin(), notes.end());
  EXPECT_EQ(notes, (std::vector<std::string>{
                       "body.flag.solver: value \"blocks\" of \"method\" is now \"two_level\"" + kUntil,
                       "body.torso.skin: value \"fibre\" of \"law\" is now \"fiber\"" + kUntil,
                       "body.torso.solver: value \"colours\" of \"ordering\" is now \"colors\"" + kUntil,
                       "body.torso.solver: value \"descent\" of \"method\" is now \"vbd\"" + kUntil}));
}

/// An old key may have an old value.
TEST(SceneRenamed, OldKeyWithOldValueIsRead) {
  const Scene scene = read_renamed(kLatticeBody + "solver.schedule = \"colours\"\n");
  EXPECT_EQ(scene.lattice_bodies.at(0).params.solver.ordering, lattice::Ordering::kColors);
  EXPECT_EQ(scene.notes.size(), 2u);
}

// Current keys and values add no note.
TEST(SceneRenamed, CurrentNamesAddNoNote) {
  const Scene scene =
      read_renamed(kLatticeBody +
                   "spacing = 0.004\nskin.law = \"fiber\"\n"
                   "solver = { method = \"vbd\", ordering = \"colors\", sleep_speed = 1e-3 }\n" +
                   kClothBody + "solver.method = \"two_level\"\n");
  EXPECT_TRUE(scene.notes.empty());
}

/// Other models have no such old names.
TEST(SceneRenamed, OldNamesOfAnotherModelAreErrors) {
  EXPECT_NE(test::error_of(kSolidBody + "step = 0.004\n").find("body.pad.step is not a key of a scene"),
            std::string::npos);
  EXPECT_NE(test::error_of(kClothBody + "solver.method = \"descent\"\n").find("found \"descent\""),
            std::string::npos);
}

// A scene with both names of a key is refused with a message that names both.
TEST(SceneRenamed, BothNamesAreAnError) {
  EXPECT_EQ(test::error_of(kLatticeBody + "solver = { schedule = \"slabs\", ordering = \"slabs\" }\n"),
            "s.toml:4:23: body.torso.solver.schedule: \"schedule\" is the old name of \"ordering\", and both "
            "are given; expected \"ordering\" alone");
  EXPECT_NE(test::error_of(kLatticeBody + "step = 0.004\nspacing = 0.005\n")
                .find("\"step\" is the old name of \"spacing\""),
            std::string::npos);
}

/// Errors about a value name the current key and the line of the old one.
TEST(SceneRenamed, ErrorsKeepTheLineOfTheOldKey) {
  EXPECT_EQ(test::error_of(kLatticeBody + "step = 7\n").substr(0, 34), "s.toml:4:8: body.torso.spacing: ex");
}

// Overrides accept old keys and old values.
TEST(SceneRenamed, OverridesAcceptOldNames) {
  const Scene scene = read_renamed(
      kLatticeBody + "spacing = 0.004\nsolver.ordering = \"slabs\"\n",
      {"body.torso.step=0.005", "body.torso.solver.schedule=colours", "body.torso.solver.method=descent"});
  EXPECT_EQ(scene.lattice_bodies.at(0).spacing, 0.005) << "an old name replaces the value of the current one";
  EXPECT_EQ(scene.lattice_bodies.at(0).params.solver.ordering, lattice::Ordering::kColors);
  EXPECT_EQ(scene.lattice_bodies.at(0).params.solver.method, lattice::Method::kVbd);
  std::vector<std::string> notes = scene.notes;
  std::sort(notes.begin(), notes.end());
  EXPECT_EQ(notes, (std::vector<std::string>{
                       "body.torso.solver: key \"schedule\" is now \"ordering\"" + kUntil,
                       "body.torso.solver: value \"colours\" of \"ordering\" is now \"colors\"" + kUntil,
                       "body.torso.solver: value \"descent\" of \"method\" is now \"vbd\"" + kUntil,
                       "body.torso: key \"step\" is now \"spacing\"" + kUntil}));
}

// Overrides replace and remove old keys of the text.
TEST(SceneRenamed, OverridesReplaceOldKeysOfText) {
  const std::string text = kLatticeBody + "step = 0.004\n";
  EXPECT_EQ(read_renamed(text, {"body.torso.spacing=0.006"}).lattice_bodies.at(0).spacing, 0.006);
  EXPECT_EQ(read_renamed(text, {"body.torso.step="}).lattice_bodies.at(0).spacing, 0);
  EXPECT_EQ(read_renamed(text, {"body.torso.spacing="}).lattice_bodies.at(0).spacing, 0);
  const Scene table = read_renamed(kLatticeBody, {"body.torso.solver={ schedule = \"colours\" }"});
  EXPECT_EQ(table.lattice_bodies.at(0).params.solver.ordering, lattice::Ordering::kColors);
}

// The text of a scene is rewritten with the current names; comments are kept.
TEST(SceneRenamed, TextIsRewrittenWithCurrentNames) {
  const std::string text = "# é\n" + kLatticeBody +
                           "\"step\" = 0.004  # of the lattice\nsolver.schedule = \"colours\"\n" +
                           kClothBody + "hold.h.ball = { radius = 0.1, centre = [1, 2, 3] }\n";
  const std::string expected = "# é\n" + kLatticeBody +
                               "spacing = 0.004  # of the lattice\nsolver.ordering = \"colors\"\n" +
                               kClothBody + "hold.h.ball = { radius = 0.1, center = [1, 2, 3] }\n";
  EXPECT_EQ(with_current_names(text, "s.toml"), expected);
  EXPECT_EQ(with_current_names(expected, "s.toml"), expected);
  EXPECT_EQ(with_current_names("[world", "s.toml"), "[world");
}

// An edited scene text has the current names.
TEST(SceneRenamed, EditedTextHasCurrentNames) {
  const Result<std::string> text =
      with_values(kLatticeBody + "step = 0.004\n", "s.toml", {"body.torso.step=0.005"});
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(*text, kLatticeBody + "spacing = 0.005\n");
  const Scene scene = read_renamed(kLatticeBody + "solver.sleep = 1e-3\n");
  EXPECT_EQ(scene_value(scene, "body.torso.solver.sleep_speed"), "1e-3");
  const Scene overridden = read_renamed(kLatticeBody, {"body.torso.solver.sleep=2e-3"});
  EXPECT_EQ(scene_value(overridden, "body.torso.solver.sleep_speed"), "2e-3");
}

// The notes about old names reach the notes of the world.
TEST(SceneRenamed, NotesReachWorld) {
  const Scene scene = read_renamed(kClothBody + "solver.method = \"blocks\"\n");
  const Result<World> world = load_world(Exec(1), scene);
  ASSERT_TRUE(world) << world.error().message;
  const std::vector<std::string> notes = notes_of(*world);
  ASSERT_FALSE(notes.empty());
  EXPECT_EQ(notes[0], "body.flag.solver: value \"blocks\" of \"method\" is now \"two_level\"" + kUntil);
}

}  // namespace
}  // namespace turgor

#include "turgor/sim/scene/scene_edit.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

constexpr const char* kText = R"(# A torso with µ in a comment.
[world]
duration = 2.0      # s

[body.torso]
model = "lattice"
ct = { phantom = "torso" }
skin = { tension = 45, stiffness = 300 }    # N/m
tissue = {}

[body.torso.solver]
sweeps = 4  # µ
)";

std::string edited(const std::vector<std::string>& overrides) {
  const Result<std::string> text = with_values(kText, "a.toml", overrides);
  EXPECT_TRUE(text) << text.error().message;
  return text ? *text : "";
}

/// Expects that the edited text equals the scene with these overrides.
void expect_same_scene(const std::vector<std::string>& overrides) {
  const Result<Scene> saved = parse_scene(edited(overrides), "a.toml"),
                      set = parse_scene(kText, "a.toml", overrides);
  ASSERT_TRUE(saved) << saved.error().message;
  ASSERT_TRUE(set) << set.error().message;
  const lattice::Params &a = saved->lattice_bodies[0].params, &b = set->lattice_bodies[0].params;
  EXPECT_EQ(saved->duration, set->duration);
  EXPECT_EQ(saved->gravity, set->gravity);
  EXPECT_EQ(a.skin.tension_along, b.skin.tension_along);
  EXPECT_EQ(a.skin.shear, b.skin.shear);
  EXPECT_EQ(a.solver.sweeps, b.solver.sweeps);
  EXPECT_EQ(a.solver.damping, b.solver.damping);
  EXPECT_EQ(a.tissue.fat, b.tissue.fat);
  EXPECT_EQ(saved->output.every, set->output.every);
  EXPECT_EQ(saved->output.window, set->output.window);
}

// A saved scene equals the scene with overrides, in every notation of the key.
TEST(SceneEdit, SavedSceneEqualsOverrides) {
  for (const char* one :
       {"world.duration=3.5", "world.gravity=[0, 0, -9.81]", "body.torso.skin.tension=60.5",
        "body.torso.skin.shear=80", "body.torso.solver.sweeps=7", "body.torso.solver.damping=2",
        "body.torso.tissue.fat=4e3", "output.snapshots.every=0.25", "output.window=bone"})
    expect_same_scene({one});
  expect_same_scene({"body.torso.skin.tension=50", "world.gravity=[1, 2, 3]", "body.torso.tissue.fat=6e3",
                     "body.torso.skin.tension=55", "output.window=lung"});
}

// The rest of the text is unchanged.
TEST(SceneEdit, KeepsOtherText) {
  EXPECT_EQ(edited({}), kText);
  std::string expected = kText;
  expected.replace(expected.find("tension = 45"), 12, "tension = 62");
  EXPECT_EQ(edited({"body.torso.skin.tension=62"}), expected);
  expected = kText;
  expected.replace(expected.find("sweeps = 4"), 10, "sweeps = 12");
  EXPECT_EQ(edited({"body.torso.solver.sweeps=12"}), expected);
}

// The effective value is read from the override or from the text.
TEST(SceneEdit, ReadsEffectiveValue) {
  const Result<Scene> scene = parse_scene(kText, "a.toml", {"body.torso.skin.tension=70"});
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene_value(*scene, "body.torso.skin.tension"), "70");
  EXPECT_EQ(scene_value(*scene, "body.torso.skin.stiffness"), "300");
  EXPECT_EQ(scene_value(*scene, "body.torso.solver.sweeps"), "4");
  EXPECT_EQ(scene_value(*scene, "world.gravity"), "");
}

// Overrides that cannot be written into the text are errors.
TEST(SceneEdit, RejectsUnwritableOverrides) {
  for (const char* one : {"world.duration=", "world.duration.more=3", "alone=1"}) {
    const Result<std::string> text = with_values(kText, "a.toml", {one});
    EXPECT_FALSE(text) << one;
  }
  EXPECT_FALSE(with_values("[world", "a.toml", {"world.duration=3"}));
}

// Cuts of a session become incisions of the saved scene.
TEST(SceneEdit, SavesCutsAsIncisions) {
  const Result<Scene> scene = parse_scene(kText, "a.toml");
  ASSERT_TRUE(scene);
  const std::vector<lattice::Incision> cuts = {
      {.name = "torso", .from = {0.1, -0.2, 0.3}, .to = {0.1, -0.2, 0.2}, .depth = 0.012, .duration = 0.5},
      {.name = "torso", .from = {0, -0.2, 0.3}, .to = {0, -0.2, 0.2}, .depth = 0.008, .duration = 0.25}};
  const Result<Scene> saved = parse_scene(scene->text + incisions_text(*scene, cuts), "a.toml");
  ASSERT_TRUE(saved) << saved.error().message;
  ASSERT_EQ(saved->incisions.size(), 2u);
  EXPECT_EQ(saved->incisions[1].blade.to, cuts[1].to);
  EXPECT_EQ(saved->incisions[0].blade.depth, 0.012);
}

}  // namespace
}  // namespace turgor

// Fabric of a cloth and texture of a surface that a person changes in a running world.
#include <gtest/gtest.h>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/requests.hpp"

namespace turgor {
namespace {

const Exec kKeysExec(1);

Scene keys_scene(const std::string& text, const std::vector<std::string>& overrides = {}) {
  Result<Scene> scene = parse_scene(text, "keys.toml", overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}
World keys_world(const Scene& scene) {
  Result<World> world = load_world(kKeysExec, scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}
void run_changed(World& world, int count) {
  for (int n = 0; n < count; n++) ASSERT_TRUE(step(kKeysExec, world));
}
/// Reason why a key of a scene waits for a restart.
std::string why_waits(const std::string& text, const std::string& path) {
  const Scene scene = keys_scene(text);
  for (const SceneKey& key : scene_keys(scene.text, scene.file))
    if (key.path == path) return why_not_live(scene, key);
  return "no such key";
}

/// A flag that hangs from two corners in the wind.
std::string flag_text(const std::string& law) {
  return "[world]\ngravity = [0, 0, -9.81]\n[body.flag]\nmodel = \"cloth\"\n"
         "sheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0, 0.2], columns = 10, rows = 10 }\n"
         "wind = { velocity = [3, 4, 0] }\nhold.top = { vertices = [110, 120] }\nfabric = { law = \"" +
         law + "\" }\n";
}
struct FabricChange {
  const char *law, *key, *value;
};
constexpr FabricChange kFabricChanges[] = {
    {"sheet", "density", "0.5"},        {"sheet", "warp", "400"},      {"sheet", "weft", "2000"},
    {"sheet", "shear", "30"},           {"sheet", "poisson", "0.2"},   {"sheet", "rigidity_warp", "3e-4"},
    {"sheet", "rigidity_weft", "2e-4"}, {"springs", "density", "0.5"}, {"springs", "warp", "400"},
};

// A cloth whose fabric changes gives the same bits as one that was loaded with it, held vertices included.
// The change back restores the model.
TEST(ChangeKeys, FabricEqualsLoadedFabric) {
  for (const auto& [law, name, value] : kFabricChanges) {
    const std::string text = flag_text(law), key = std::string("body.flag.fabric.") + name;
    EXPECT_EQ(why_waits(text, key), "") << key;
    auto scene = std::make_shared<const Scene>(keys_scene(text));
    World changed = keys_world(*scene), plain = keys_world(*scene),
          loaded = keys_world(keys_scene(text, {key + "=" + value}));
    const Status applied = apply_request(kKeysExec, ChangeRequest{key, value}, scene, changed);
    ASSERT_TRUE(applied) << applied.error().message;
    run_changed(changed, 4), run_changed(loaded, 4), run_changed(plain, 4);
    EXPECT_EQ(state_hash(changed), state_hash(loaded)) << law << " " << key;
    EXPECT_NE(state_hash(changed), state_hash(plain)) << law << " " << key;
    // and back
    ASSERT_TRUE(apply_request(kKeysExec, ChangeRequest{key, std::nullopt}, scene, changed));
    const cloth::Model &back = changed.cloth_bodies[0].model, &own = plain.cloth_bodies[0].model;
    EXPECT_EQ(back.params.fabric, own.params.fabric) << key;
    EXPECT_EQ(back.mass, own.mass) << key;
    EXPECT_EQ(back.rows.stiffness, own.rows.stiffness) << key;
    EXPECT_EQ(changed.cloth_bodies[0].state->free_mass, plain.cloth_bodies[0].state->free_mass) << key;
  }
}

// A fabric that changes with a scaled stiffness keeps its scale. Keys that number the rows again, and keys of
// another law, wait.
TEST(ChangeKeys, FabricKeepsItsScale) {
  const std::string text = flag_text("sheet") + "stiffness_scale = 2\n";
  auto scene = std::make_shared<const Scene>(keys_scene(text));
  World changed = keys_world(*scene), loaded = keys_world(keys_scene(text, {"body.flag.fabric.warp=500"}));
  ASSERT_TRUE(apply_request(kKeysExec, ChangeRequest{"body.flag.fabric.warp", "500"}, scene, changed));
  EXPECT_EQ(changed.cloth_bodies[0].model.params.fabric, loaded.cloth_bodies[0].model.params.fabric);
  EXPECT_EQ(changed.cloth_bodies[0].model.params.fabric.warp, 1000);
  EXPECT_NE(why_waits(text, "body.flag.fabric.direction"), "");
  EXPECT_NE(why_waits(flag_text("springs"), "body.flag.fabric.bend"), "");
  EXPECT_EQ(why_waits(flag_text("springs"), "body.flag.fabric.poisson"), "the fabric has another law");
}

// The waves of a surface change under a sliding tool: its force then has the bits of a world that was loaded
// with them.
TEST(ChangeKeys, TextureEqualsLoadedTexture) {
  const std::string text = test::sfem_scene_text(
      "cache = false\npatch = { radius = 0.016, refinement = 2 }\ntexture = { roughness = 2e-6 }\n");
  for (const auto& [name, value] : {std::pair("roughness", "8e-6"), std::pair("wavelength", "3e-3")}) {
    const std::string key = std::string("body.pad.texture.") + name;
    EXPECT_EQ(why_waits(text, key), "") << key;
    auto scene = std::make_shared<const Scene>(keys_scene(text));
    World changed = keys_world(*scene), plain = keys_world(*scene),
          loaded = keys_world(keys_scene(text, {key + "=" + value}));
    ASSERT_TRUE(apply_request(kKeysExec, ChangeRequest{key, value}, scene, changed));
    run_changed(changed, 14), run_changed(loaded, 14), run_changed(plain, 14);
    const ForceSample &a = changed.tools[0].samples.back(), &b = loaded.tools[0].samples.back(),
                      &c = plain.tools[0].samples.back();
    EXPECT_GT(norm(a.force), 0) << key;
    EXPECT_EQ(a.force, b.force) << key;
    EXPECT_NE(a.force, c.force) << key;
  }
}

/// A body under a finger: elements or chains.
std::string pressed_text(const std::string& model, const std::string& keys) {
  if (model == "sfem")
    return test::sfem_scene_text("cache = false\npatch = { radius = 0.016, refinement = 2 }\n" + keys);
  return "[world]\nduration = 0.5\n[body.pad]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\" }\n" +
         keys +
         "\n[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\n"
         "press = { at_fraction = [0.5, 0.5, 1], depth = 0.003, start = 0, duration = 0.1, hold = 0.3 }\n";
}

// The pairs of elements and chains change: before a press the forces then have the bits of a world that was
// loaded with them. A change while the tool rests adds no force, and the tissue stays as it is.
TEST(ChangeKeys, ViscosityEqualsLoadedViscosity) {
  for (const std::string model : {"sfem", "rhombus"})
    for (const auto& [keys, name, value] :
         {std::tuple("", "ratio", "0.8"),
          std::tuple("viscosity = { ratio = 0.8, time = 0.2 }\n", "time", "0.05"),
          std::tuple("viscosity = { pairs = [[0.3, 0.1]] }\n", "pairs", "[[0.3, 0.1], [0.2, 0.4], [0.1, 2]]"),
          std::tuple("viscosity = { pairs = [[0.3, 0.1], [0.2, 0.4]] }\n", "pairs[1]", "[0.4, 0.05]")}) {
      const std::string text = pressed_text(model, keys), key = std::string("body.pad.viscosity.") + name;
      EXPECT_EQ(why_waits(text, key), "") << model << key;
      auto scene = std::make_shared<const Scene>(keys_scene(text));
      World changed = keys_world(*scene), plain = keys_world(*scene),
            loaded = keys_world(keys_scene(text, {key + "=" + value}));
      const Status applied = apply_request(kKeysExec, ChangeRequest{key, value}, scene, changed);
      ASSERT_TRUE(applied) << applied.error().message;
      run_changed(changed, 8), run_changed(loaded, 8), run_changed(plain, 8);
      const ForceSample &a = changed.tools[0].samples.back(), &b = loaded.tools[0].samples.back(),
                        &c = plain.tools[0].samples.back();
      EXPECT_GT(norm(a.force), 0) << model << key;
      EXPECT_EQ(a.force, b.force) << model << key;
      EXPECT_NE(a.force, c.force) << model << key;
    }
}

// Elastic tissue that becomes viscous under a resting tool keeps its force, and so does viscous tissue that
// has relaxed and becomes elastic.
TEST(ChangeKeys, ViscosityOfRestingTissueAddsNoForce) {
  for (const std::string model : {"sfem", "rhombus"})
    for (const auto& [before, after] : {std::pair("0", "2"), std::pair("2", "0")}) {
      const std::string text =
          pressed_text(model, std::string("viscosity = { ratio = ") + before + ", time = 0.005 }\n");
      auto scene = std::make_shared<const Scene>(keys_scene(text));
      World world = keys_world(*scene);
      run_changed(world, 8);
      const Vec3d held(world.tools[0].samples.back().force);
      ASSERT_TRUE(apply_request(kKeysExec, ChangeRequest{"body.pad.viscosity.ratio", after}, scene, world));
      run_changed(world, 1);
      EXPECT_LT(norm(Vec3d(world.tools[0].samples.back().force) - held), 1e-3 * norm(held))
          << model << before;
      EXPECT_GT(norm(held), 0.01) << model;
    }
}

/// A nonlinear body under a finger that rests after its press.
std::string stiffening_text(const std::string& law) {
  return "[world]\nduration = 0.5\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.03], count "
         "= [8, "
         "8, 4] }\nfixed = \"bottom\"\nyoung = 5e3\npoisson = 0.4\ncache = false\n"
         "patch = { radius = 0.016, refinement = 2 }\n" +
         law +
         "[tool.finger]\nbody = \"pad\"\nshape = { sphere = 0.006 }\nfriction = 0\n"
         "press = { at_fraction = [0.5, 0.5, 1], depth = 0.003, start = 0, duration = 0.1, hold = 0.3 }\n";
}

// The exponent of a nonlinear patch changes: before a press the forces then have the bits of a world that was
// loaded with it.
TEST(ChangeKeys, StiffeningEqualsLoadedStiffening) {
  const std::string text = stiffening_text("law = \"exponential\"\nstiffening = 2\n"),
                    key = "body.pad.stiffening";
  EXPECT_EQ(why_waits(text, key), "");
  auto scene = std::make_shared<const Scene>(keys_scene(text));
  World changed = keys_world(*scene), plain = keys_world(*scene),
        loaded = keys_world(keys_scene(text, {key + "=8"}));
  const Status applied = apply_request(kKeysExec, ChangeRequest{key, "8"}, scene, changed);
  ASSERT_TRUE(applied) << applied.error().message;
  run_changed(changed, 8), run_changed(loaded, 8), run_changed(plain, 8);
  const Vec3d force(changed.tools[0].samples.back().force);
  EXPECT_EQ(force, Vec3d(loaded.tools[0].samples.back().force));
  EXPECT_GT(norm(force), 1.02 * norm(Vec3d(plain.tools[0].samples.back().force)));
}

// Under a tool that rests without friction (which has a history), the force goes to that of the new law,
// whichever law it had before.
TEST(ChangeKeys, StiffeningUnderRestingToolFindsItsForce) {
  const std::string text = stiffening_text("law = \"exponential\"\nstiffening = 2\n"),
                    key = "body.pad.stiffening";
  auto scene = std::make_shared<const Scene>(keys_scene(text));
  World changed = keys_world(*scene), loaded = keys_world(keys_scene(text, {key + "=8"}));
  run_changed(changed, 8), run_changed(loaded, 16);
  ASSERT_TRUE(apply_request(kKeysExec, ChangeRequest{key, "8"}, scene, changed));
  run_changed(changed, 8);
  const Vec3d expected(loaded.tools[0].samples.back().force);
  EXPECT_LT(norm(Vec3d(changed.tools[0].samples.back().force) - expected), 2e-3 * norm(expected));
}

// Other laws have no exponent, and say so.
TEST(ChangeKeys, StiffeningOfOtherLawsSaysWhy) {
  for (const char* law : {"", "law = \"neo_hookean\"\n"})
    EXPECT_EQ(why_waits(stiffening_text(law), "body.pad.stiffening"),
              "only law = \"exponential\" has an exponent");
}

// A nonlinear patch and a body with a needle stay elastic, and say so.
TEST(ChangeKeys, ViscosityThatWaitsSaysWhy) {
  const std::string key = "body.pad.viscosity.ratio";
  EXPECT_EQ(why_waits(test::sfem_scene_text("law = \"neo_hookean\"\n"), key),
            "a nonlinear patch does not relax");
  const std::string needle =
      "[world]\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.06, 0.06, 0.06], count = [4, 4, 4] }\n"
      "fixed = \"bottom\"\n[tool.needle]\nbody = \"pad\"\nshape = { needle = 0.06, diameter = 0.001 }\n"
      "press = { at = [0.03, 0.03, 0.06], depth = 0.02, start = 0, duration = 1 }\n";
  EXPECT_EQ(why_waits(needle, key), "needles need an elastic body");
}

}  // namespace
}  // namespace turgor

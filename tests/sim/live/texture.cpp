// Textures of every model in a world: vibration of a sliding tool, bits, live changes, reports and errors.
#include <algorithm>
#include <fstream>
#include <numbers>

#include "tests/sim/haptic_hand.hpp"
#include "tests/sim/resumed.hpp"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/driven_ticks.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/report/report_texture.hpp"

namespace turgor {
namespace {

constexpr const char* kModels[] = {"sfem", "rhombus", "lattice", "cloth", "rigid"};
constexpr double kRoughness = 5e-6, kWavelength = 2e-3;
constexpr const char* kWaves = "texture = { roughness = 5e-6, wavelength = 2e-3 }\n";

const char* body_keys(const std::string& model) {
  if (model == "sfem")
    return "block = { size = [0.06, 0.06, 0.03], count = [8, 8, 4] }\nfixed = \"bottom\"\nyoung = 5e3\n"
           "poisson = 0.4\ncache = false\npatch = { radius = 0.02 }\n";
  if (model == "rhombus") return "surface = { phantom = \"liver\", detail = 0.4 }\n";
  if (model == "lattice") return "ct = \"block.nii\"\nblock = 2\nfixed = \"bone\"\n";
  if (model == "cloth")
    return "sheet = { corner = [0, 0, 0], side = [0.15, 0, 0], up = [0, 0.1, 0], columns = 15, rows = 10 }\n"
           "fabric = { law = \"sheet\", density = 0.3, warp = 300, weft = 300, shear = 60 }\n"
           "solver = { method = \"two_level\" }\ndamping = { motion = 4 }\n"
           "hold.left = { box = [[-1, -1, -1], [0.001, 1, 1]] }\nhold.right = { box = [[0.149, -1, -1], [1, "
           "1, 1]] }\n"
           "hold.front = { box = [[-1, -1, -1], [1, 0.001, 1]] }\nhold.back = { box = [[-1, 0.099, -1], [1, "
           "1, 1]] }\n";
  return "shape = { box = [0.1, 0.1, 0.02] }\ndensity = 1000\nfixed = true\n";
}

/// Down within 0.1 s, a rest of 0.1 s, and a slide of 20 mm and more within 0.4 s.
const char* tool_keys(const std::string& model) {
  if (model == "sfem")
    return "shape = { sphere = 0.006 }\nfriction = 0.1\npress = { at_fraction = [0.3, 0.5, 1], to_fraction = "
           "[0.7, 0.5, 1], "
           "depth = 0.003, start = 0, duration = 0.1, hold = 0.1, slide = 0.4 }\n";
  if (model == "rhombus")
    return "shape = { sphere = 0.006 }\npress = { at_fraction = [0.3, 0.5, 1], to_fraction = [0.45, 0.5, 1], "
           "depth = 0.006, start = 0, duration = 0.1, hold = 0.1, slide = 0.4 }\n";
  if (model == "lattice")
    return "shape = { sphere = 0.014 }\nfriction = 0.1\npress = { at_fraction = [0.35, 0, 0.5], to_fraction "
           "= "
           "[0.6, 0, 0.5], "
           "depth = 0.005, start = 0, duration = 0.1, hold = 0.1, slide = 0.4 }\n";
  if (model == "cloth")
    return "shape = { sphere = 0.012 }\nfriction = 0.1\ninterpolation = \"linear\"\n"
           "path = [[0, 0.06, 0.05, 0.014], [0.1, 0.06, 0.05, 0.006], [0.2, 0.06, 0.05, 0.006], [0.6, 0.09, "
           "0.05, 0.006]]\n";
  return "shape = { sphere = 0.006 }\nfriction = 0.1\ninterpolation = \"linear\"\n"
         "path = [[0, 0, 0, 0.018], [0.1, 0, 0, 0.0157], [0.2, 0, 0, 0.0157], [0.6, 0.03, 0, 0.0157]]\n";
}

std::string text_of(const std::string& model, const std::string& texture) {
  return "[world]\nduration = 0.6\nframe_rate = 60\n[body.organ]\nmodel = \"" + model + "\"\n" +
         body_keys(model) + texture + "[tool.finger]\nbody = \"organ\"\n" + tool_keys(model);
}
Scene scene_of_model(const std::string& model, const std::string& texture,
                     const std::vector<std::string>& overrides = {}) {
  const std::filesystem::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  Result<Scene> scene = parse_scene(text_of(model, texture), folder / "organ.toml", overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}
World world_of(const Exec& exec, const Scene& scene) {
  Result<World> world = load_world(exec, scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

/// Position and force of a tool in a tick.
struct Tick {
  double time = 0;
  Vec3d position, force;
};
/// Ticks of a world whose tool follows its path in haptic ticks.
std::vector<Tick> driven_ticks(const Exec& exec, World& world, double duration = 0.6) {
  const TouchingTool tool = world.tools[0];
  DrivenTicks driven = begin_driven(world);
  std::vector<Tick> ticks;
  while (time_of(driven) < duration - 1e-9) {
    const double time = time_of(driven) + kTick;
    const std::vector<contact::ToolCommand> command{command_at(tool, time)};
    std::vector<contact::ToolReading> reading(1);
    EXPECT_TRUE(tick_driven(exec, world, driven, command, reading));
    ticks.push_back({time, command[0].pose.position, reading[0].force});
  }
  end_driven(world);
  return ticks;
}

Json texture_of(const Scene& scene, const World& world) {
  Json report;
  for_each_kind(scene, world, [&](BodyKind, const auto& scenes, const auto& bodies) {
    if (!bodies.empty()) report = texture_report(scenes[0].texture, bodies[0]);
  });
  return report;
}

// A tool that slides on a rough body differs from one on a smooth body by a vibration of a wavelength of the
// path, along the path, of an amplitude of 2π N a/λ at most. A tool that rests has none.
TEST(TextureWorld, EveryModelVibratesWhileSliding) {
  for (const std::string model : kModels) {
    const Exec exec(2);
    const Scene rough_scene = scene_of_model(model, kWaves);
    World rough_world = world_of(exec, rough_scene), smooth_world = world_of(exec, scene_of_model(model, ""));
    const std::vector<Tick> rough = driven_ticks(exec, rough_world),
                            smooth = driven_ticks(exec, smooth_world);
    double resting = 0, slid = 0, before = 0, normal = 0;
    int waves = -1;
    Vec3d first, last;
    for (std::size_t i = 0; i < rough.size(); i++) {
      const Vec3d d = rough[i].force - smooth[i].force;
      if (rough[i].time > 0.13 && rough[i].time < 0.19) resting = std::max(resting, norm(d));
      slid = std::max(slid, norm(d)), normal = std::max(normal, norm(smooth[i].force));
      if (rough[i].time < 0.25 || rough[i].time > 0.55) continue;
      const double along = dot(d, normalized(rough.back().position - rough[195].position));
      if (before < 0 && along >= 0) {
        if (waves++ < 0) first = rough[i].position;
        last = rough[i].position;
      }
      before = along;
    }
    EXPECT_GT(normal, 0.02) << model;
    EXPECT_LT(resting, 0.02 * slid) << model;
    ASSERT_GT(waves, 5) << model;
    EXPECT_NEAR(norm(last - first) / waves, kWavelength, 0.1 * kWavelength) << model;
    const double amplitude = 2 * std::numbers::pi * normal * kRoughness / kWavelength;
    EXPECT_LT(slid, 1.01 * amplitude) << model;
    EXPECT_GT(slid, 0.5 * amplitude) << model;
    const Json report = texture_of(rough_scene, rough_world);
    EXPECT_NEAR(report.value("roughness_um", 0.0), 5, 1e-6) << model;
    // the report has the amplitude, which changes with the normal force from crest to crest
    const double reported = report.value("force_max_N", 0.0);
    EXPECT_LT(slid, 1.001 * reported) << model;
    EXPECT_GT(slid, 0.97 * reported) << model;
    EXPECT_GT(report.value("frequency_max_Hz", 0.0), 10) << model;
    EXPECT_TRUE(texture_of(rough_scene, smooth_world).is_null()) << model;
  }
}

// Forces on textures have the same bits on 1, 2 and 8 threads.
TEST(TextureWorld, EqualBitsOnAnyThreads) {
  for (const std::string model : kModels) {
    std::vector<Vec3d> one;
    for (const int threads : {1, 2, 8}) {
      const Exec exec(threads);
      World world = world_of(exec, scene_of_model(model, kWaves));
      std::vector<Vec3d> forces;
      for (const Tick& tick : driven_ticks(exec, world, 0.35)) forces.push_back(tick.force);
      if (threads == 1) one = forces;
      EXPECT_EQ(forces, one) << model << " on " << threads;
    }
    EXPECT_GT(norm(one.back()), 0) << model;
  }
}

// A hand with the passivity controller gets no energy from the steepest waves of any model beyond that of
// some ticks of its force.
TEST(TextureWorld, PassivityHoldsOnEveryModel) {
  constexpr double kStep = 2e-4;  // more than the hand moves in a tick [m]
  const auto lowest = [](const std::string& model, const std::string& texture, double& force) {
    World world = world_of(Exec(2), scene_of_model(model, texture, {"world.duration=2"}));
    test::HapticHand hand(world, 0);
    hand.advance(0.8);
    for_each_body(world, [&](BodyId, const auto& body) {
      if constexpr (requires { body.textures; })
        force = body.textures.empty() ? 0 : body.textures[0].largest_force;
      else
        force = body.now.textures.empty() ? 0 : body.now.textures[0].largest_force;
    });
    test::expect_harmless(hand, model);
    return hand.safety().passivity.lowest;
  };
  for (const std::string model : kModels) {
    double force = 0, none = 0;
    const double smooth = lowest(model, "", none),
                 rough = lowest(model, "texture = { roughness = 1e-3, wavelength = 2e-3 }\n", force);
    EXPECT_GT(force, 0.02) << model;
    EXPECT_EQ(none, 0) << model;
    EXPECT_GT(rough, smooth - 2 * force * kStep) << model;
  }
}

// The waves of every model change in a running world: its forces then have the bits of a world that was
// loaded with them. The file of heights waits for a restart.
TEST(TextureWorld, WavesChangeAtOnce) {
  for (const std::string model : kModels) {
    auto scene = std::make_shared<const Scene>(scene_of_model(model, kWaves));
    int found = 0;
    for (const SceneKey& key : scene_keys(scene->text, scene->file)) {
      if (!key.path.starts_with("body.organ.texture.")) continue;
      const bool is_live = key.key == "texture.roughness" || key.key == "texture.wavelength";
      EXPECT_EQ(why_not_live(*scene, key).empty(), is_live) << model << " " << key.key;
      found += is_live;
    }
    EXPECT_EQ(found, 2) << model;
    const Exec exec(2);
    const std::string key = "body.organ.texture.roughness";
    World changed = world_of(exec, *scene), plain = world_of(exec, *scene),
          loaded = world_of(exec, scene_of_model(model, kWaves, {key + "=8e-6"}));
    const Status applied = apply_request(exec, ChangeRequest{key, "8e-6"}, scene, changed);
    ASSERT_TRUE(applied) << applied.error().message;
    const std::vector<Tick> a = driven_ticks(exec, changed, 0.3), b = driven_ticks(exec, loaded, 0.3),
                            c = driven_ticks(exec, plain, 0.3);
    EXPECT_EQ(a.back().force, b.back().force) << model;
    EXPECT_NE(a.back().force, c.back().force) << model;
  }
}

// A run that continues from a state file has the bits of one that did not stop, with its phase.
TEST(TextureWorld, ResumedSlideKeepsPhase) {
  for (const std::string model : {"sfem", "rhombus"}) {
    const Exec exec(2);
    const std::filesystem::path folder = test::fresh_folder();
    const Scene scene = scene_of_model(model, kWaves);
    World world = world_of(exec, scene), resumed = world_of(exec, scene);
    const LoadedPatches loaded = loaded_patches(world);
    for (int frame = 0; frame < 18; frame++) ASSERT_TRUE(step(exec, world));
    test::expect_resumes(exec, folder / "state", loaded, world, resumed);
    const Json a = texture_of(scene, world), b = texture_of(scene, resumed);
    EXPECT_GT(a.value("force_max_N", 0.0), 0) << model;
    EXPECT_EQ(a, b) << model;
  }
}

// Bad values are refused for every model, with their key; a file of heights is read for every model.
TEST(TextureWorld, WrongValuesAreRefused) {
  for (const std::string model : kModels) {
    const auto error = [&](const std::string& texture) {
      const std::filesystem::path folder = test::fresh_folder();
      EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
      std::ofstream(folder / "skin.csv") << "0, 2, 5, 1\n4, 0, 3, 2\n";
      std::ofstream(folder / "steep.csv") << "1, 2\n3, 4\n";
      const Result<Scene> scene = parse_scene(text_of(model, texture), folder / "organ.toml", {});
      if (!scene) return scene.error().message;
      const Result<World> world = load_world(Exec(2), *scene);
      return world ? std::string() : world.error().message;
    };
    const auto expect = [&](const std::string& texture, const char* message) {
      EXPECT_NE(error("texture = { " + texture + " }\n").find(message), std::string::npos)
          << model << ": " << error("texture = { " + texture + " }\n");
    };
    expect("roughness = -1", "roughness");
    expect("wavelength = 0", "wavelength");
    expect("height_map = \"skin.csv\", roughness = 1e-6", "not both");
    expect("spacing = 1e-4", "belongs to a height_map");
    expect("height_map = \"steep.csv\"", "within 1 mm of their mean");
    expect("height_map = \"none.csv\"", "none.csv");
    EXPECT_EQ(error("texture = { height_map = \"skin.csv\", scale = 1e-6 }\n"), "") << model;
  }
}

// Frames alone have no vibration on lattices, cloth and rigid bodies, and the report says so.
TEST(TextureWorld, FramesWithoutTicksSaySo) {
  for (const std::string model : kModels) {
    const Exec exec(2);
    World world = world_of(exec, scene_of_model(model, kWaves));
    for (int frame = 0; frame < 3; frame++) ASSERT_TRUE(step(exec, world));
    const bool has_ticks = model == "sfem" || model == "rhombus";
    EXPECT_EQ(texture_warnings(world).size(), has_ticks ? 0u : 1u) << model;
  }
}

}  // namespace
}  // namespace turgor

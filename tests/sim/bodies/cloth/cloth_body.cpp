#include <fstream>

#include <gtest/gtest.h>

#include "turgor/core/gpu.hpp"
#include "turgor/sim/report/report_cloth.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

constexpr const char* kFlag = R"(
[world]
gravity = [0, 0, -9.81]
[body.flag]
model = "cloth"
sheet = { corner = [0, 0, 1], side = [0.3, 0, 0], up = [0, 0, 0.2], columns = 15, rows = 10 }
fabric = { law = "springs", density = 0.12, warp = 800 }
collision = { thickness = 0.018 }
solver = { method = "jacobi", sweeps = 4 }
wind = { velocity = [7, 0.5, 0], gusts = 0.3, turns = [[0.2, 0, 5, 0]] }
[body.flag.hold.pole]
box = [[-0.001, -1, 0], [0.001, 1, 3]]
path = [[0, 0, 0, 0], [0.5, 0, 0, 0.1]]
end = 0.5
[body.flag.obstacle.ball]
sphere = { center = [0.15, 0.15, 1.1], radius = 0.1 }
friction = 0.1
)";

Scene must_parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  Result<Scene> scene = parse_scene(text, "flag.toml", overrides);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  return std::move(*scene);
}

std::string error_of(const std::vector<std::string>& overrides, const std::string& text = kFlag) {
  const Result<Scene> scene = parse_scene(text, "flag.toml", overrides);
  if (!scene) return scene.error().message;
  const Result<World> world = load_world(Exec(1), *scene);
  return world ? "no error" : world.error().message;
}

// The keys of a scene reach the parameters of a cloth.
TEST(ClothBody, SceneKeysReachParameters) {
  const Scene scene = must_parse(kFlag);
  ASSERT_EQ(scene.cloth_bodies.size(), 1u);
  const ClothScene& flag = scene.cloth_bodies[0];
  EXPECT_EQ(std::get<cloth::Sheet>(flag.source).columns, 15);
  EXPECT_EQ(flag.params.fabric.warp, 800);
  EXPECT_EQ(flag.params.fabric.weft, 1000);
  EXPECT_EQ(flag.params.solver.method, cloth::Method::kJacobi);
  EXPECT_EQ(flag.turns[0].velocity.y, 5);
  EXPECT_EQ(flag.holds[0].path[1][3], 0.1);
  EXPECT_EQ(std::get<BallScene>(flag.obstacles[0].shape).radius, 0.1);
}

// Errors in a cloth scene name the key and its location in the file.
TEST(ClothBody, ErrorsNameSourceLocation) {
  EXPECT_NE(error_of({"body.flag.fabric.weft=-1"}).find("body.flag.fabric.weft: expected"),
            std::string::npos);
  EXPECT_NE(
      error_of({"body.flag.obstacle.ball.mesh=x.obj"})
          .find("body.flag.obstacle.ball.mesh: an obstacle has one shape: either sphere or mesh, not both"),
      std::string::npos);
  std::string two_shapes = kFlag;
  two_shapes.insert(two_shapes.find("model"), "mesh = \"x.obj\"\n");
  EXPECT_NE(error_of({}, two_shapes).find("either a sheet or a mesh"), std::string::npos);
  EXPECT_NE(error_of({"body.flag.mesh=x.obj"}).find("x.obj"), std::string::npos) << "it replaces the sheet";
  EXPECT_NE(error_of({"body.flag.sheet.up=[1,0,0]"}).find("the two sides span no area"), std::string::npos);
  EXPECT_NE(error_of({"body.flag.wind.turns=[[1,0,0,0],[0.5,1,0,0]]"}).find("ascending"), std::string::npos);
  EXPECT_NE(error_of({"body.flag.obstacle.ball.skin=torso"}).find("skin is not a key"), std::string::npos);
  EXPECT_NE(error_of({"body.flag.hold.pole.box=[[5,5,5],[6,6,6]]"})
                .find("hold.pole: no vertex of the cloth is in the box; the body is between (0, 0, 1) m and "
                      "(0.3, 0, 1.2) m; its nearest point, (0.3, 0, 1.2) m, is"),
            std::string::npos);
  EXPECT_NE(error_of({"body.flag.hold.pole.start=0.5", "body.flag.hold.pole.end=0.2"})
                .find("body.flag.hold.pole.end: expected a time after the start at 0.5 s, found 0.2 s"),
            std::string::npos);
  EXPECT_NE(
      error_of({"body.flag.hold.pole.vertices=[999]"}).find("expected vertices from 0 to 175, found 999"),
      std::string::npos);
  EXPECT_NE(error_of({"body.flag.collision.thickness=0.1"}).find("thickness: expected at most 0.02 m"),
            std::string::npos);
  EXPECT_NE(error_of({"body.flag.clor=1"}).find("clor"), std::string::npos);
}

// Cloth solvers that do not run on a GPU are refused with a message that names the key.
TEST(ClothBody, RejectsKeysUnsupportedOnGpu) {
  const std::string gpu = "world.device=gpu";
  const auto expect = [](const std::vector<std::string>& overrides, const std::string& sentence) {
    const std::string error = error_of(overrides);
    EXPECT_NE(error.find(sentence), std::string::npos) << error;
  };
  expect({gpu, "body.flag.solver.method=blocks"},
         "body.flag.solver: on device = \"gpu\" cloth is solved by sweeps only: set solver.method = "
         "\"chebyshev\"");
  expect({"body.flag.device=gpu", "body.flag.solver.method=conjugate gradients"},
         "flag.toml:9:10: body.flag.solver: on device = \"gpu\"");
  EXPECT_EQ(error_of({gpu, "body.flag.device=cpu"}), "no error");
}

// Without a GPU, cloth with device = "gpu" is refused with a message.
TEST(ClothBody, ReportsMissingGpu) {
  if (const Result<Gpu> gpu = open_gpu(); gpu) GTEST_SKIP() << "this machine has a GPU: " << gpu->name;
  for (const char* thickness : {"0.018", "0.004"}) {  // with obstacles, and also in large triangles
    const Scene scene =
        must_parse(kFlag, {"world.device=gpu", "body.flag.collision.thickness=" + std::string(thickness)});
    const Result<World> world = load_world(Exec(1), scene);
    ASSERT_FALSE(world);
    EXPECT_NE(world.error().message.find("body.flag: device = \"gpu\": expected a"), std::string::npos)
        << world.error().message;
  }
}

// An obstacle of a cloth is another body of the scene, given by its name.
TEST(ClothBody, ObstacleNamesOtherBody) {
  const std::string bodies = R"(
[body.pad]
model = "sfem"
block = { size = [0.1, 0.1, 0.1], count = [2, 2, 2] }
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 4 }
[body.leg]
model = "lattice"
ct = { phantom = "leg", size = [16, 16, 16] }
[body.flag.obstacle.under]
body = )";
  const std::vector<std::pair<std::string, BodyId>> kinds = {{"\"pad\"", {BodyKind::kSfem, 0}},
                                                             {"\"liver\"", {BodyKind::kRhombus, 0}},
                                                             {"\"leg\"", {BodyKind::kLattice, 0}}};
  for (const auto& [name, expected] : kinds)
    EXPECT_EQ(std::get<BodyId>(must_parse(kFlag + bodies + name).cloth_bodies[0].obstacles[1].shape),
              expected);
  const auto error = [&](const std::string& name) {
    const Result<Scene> scene = parse_scene(kFlag + bodies + name, "flag.toml");
    return scene ? "no error" : scene.error().message;
  };
  EXPECT_NE(error("\"livr\"")
                .find("body.flag.obstacle.under.body: the scene has no body livr with model = "
                      "\"lattice\", \"sfem\", \"rhombus\" or \"rigid\"; did you mean liver?"),
            std::string::npos)
      << error("\"livr\"");
  EXPECT_NE(error("\"flag\"").find("has no body flag with model"), std::string::npos)
      << "a cloth is no obstacle of itself";
  EXPECT_NE(error("3").find("body.flag.obstacle.under.body"), std::string::npos);
}

// Holds follow their path and release at their end; the wind changes at its turns.
TEST(ClothBody, HoldsFollowPathAndRelease) {
  const Scene scene = must_parse(kFlag);
  const Exec exec(2);
  Result<World> world = load_world(exec, scene);
  ASSERT_TRUE(world) << world.error().message;
  ClothBody& flag = world->cloth_bodies[0];
  const auto corner = [&flag] { return flag.state->x[std::size_t(flag.model.model_vertex[0])]; };
  for (int frame = 0; frame < 29; frame++) ASSERT_TRUE(step(exec, *world, frame == 20));
  EXPECT_NEAR(corner().z, 1 + 0.1 * 29 / 30, 1e-5);
  EXPECT_EQ(flag.air.velocity, (Vec3d{0, 5, 0}));
  EXPECT_EQ(flag.state->holds.size(), 11u);
  for (int frame = 0; frame < 30; frame++) ASSERT_TRUE(step(exec, *world));
  EXPECT_TRUE(flag.state->holds.empty());
  EXPECT_GT(norm(corner() - Vec3{0, 0, 1.1f}), 0.01f);
  EXPECT_EQ(flag.samples.size(), 59u);
  EXPECT_GT(flag.samples[20].energy, 0);
  const Json report = report_body({exec, *world, Measures()}, ClothScene(), flag, {BodyKind::kCloth, 0});
  EXPECT_EQ(report.at("vertices"), 176);
  EXPECT_EQ(report.at("series").size(), 59u);
  EXPECT_EQ(report.at("snapshots").size(), 1u);
}

// A ball hold grips the vertices in it and reports the weight of the lifted sheet; an empty hold is warned
// of.
TEST(ClothBody, BallHoldReportsLiftingForce) {
  const std::string text = R"(
[world]
gravity = [0, 0, -9.81]
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0.01], side = [0.2, 0, 0], up = [0, 0.2, 0], columns = 20, rows = 20 }
damping = { motion = 2 }
fabric = { law = "springs" }
solver = { method = "sweeps", sweeps = 48 }
wind = { density = 0 }
[body.sheet.obstacle.floor]
plane = { through = [0, 0, 0] }
[body.sheet.hold.grip]
ball = { center = [0.1, 0.1, 0], radius = 0.015 }
start = 0.5
path = [[0.5, 0, 0, 0], [2, 0, 0, 0.5]]
[body.sheet.hold.nothing]
ball = { center = [1, 1, 1], radius = 0.015 }
)";
  const Exec exec(1);
  Result<World> world = load_world(exec, must_parse(text));
  ASSERT_TRUE(world) << world.error().message;
  for (int frame = 0; frame < 300; frame++) ASSERT_TRUE(step(exec, *world));
  const ClothBody& sheet = world->cloth_bodies[0];
  const ClothHold& grip = sheet.holds[0];
  EXPECT_EQ(grip.vertices.size(), 9u) << "on a grid of 10 mm";
  EXPECT_EQ(norm(grip.force[20]), 0) << "before the start of the hold";
  const double weight = sheet.model.total_mass * 9.81;
  Vec3d mean;
  for (std::size_t n = 270; n < 300; n++) mean += grip.force[n] / 30.0;
  EXPECT_NEAR(mean.z, weight, 0.02 * weight) << "N: the whole sheet is lifted";
  const std::vector<std::string> warnings = cloth_warnings(*world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(
      warnings[0],
      "sheet: hold.nothing: no vertex of the cloth was in its ball at 0 s: the hold is empty; the body is "
      "between (0, 0, 0.01) m and (0.2, 0.2, 0.01) m; its nearest point, (0.2, 0.2, 0.01) m, is 1.5 m away");
  const Json report = report_body({exec, *world, Measures()}, ClothScene(), sheet, {BodyKind::kCloth, 0});
  EXPECT_NEAR(report.at("holds")[0].at("force_N")[2].get<double>(), weight, 0.02 * weight);
  EXPECT_NE(parse_scene(text + "box = [[0, 0, 0], [1, 1, 1]]\n", "s.toml").error().message.find("either"),
            std::string::npos);
}

// A real garment hangs from its shoulders without intersecting itself.
TEST(ClothBody, RealGarmentHangsWithoutCrossing) {
  const std::filesystem::path file =
      std::filesystem::path(TURGOR_SOURCE_DIR) / "../shared/data/mesh/tshirt.obj";
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << file << " is absent: real data is not part of the project";
  const Scene scene = must_parse(R"(
[world]
gravity = [0, 0, -9.81]
[body.shirt]
model = "cloth"
mesh = "x.obj"
scale = 0.07
up = "y"
fabric = { law = "springs" }
solver = { method = "sweeps" }
collision = { thickness = 0.008 }
[body.shirt.hold.shoulders]
box = [[-1, -1, 0.83], [1, 1, 1]]
)",
                                 {"body.shirt.mesh=" + file.string()});
  const Exec exec(2);
  Result<World> world = load_world(exec, scene);
  ASSERT_TRUE(world) << world.error().message;
  const ClothBody& shirt = world->cloth_bodies[0];
  EXPECT_EQ(shirt.model.triangles.size(), 3726u);
  for (int frame = 0; frame < 30; frame++) {
    const Result<FrameReport> report = step(exec, *world);
    ASSERT_TRUE(report && report->finite);
  }
  EXPECT_EQ(cloth::self_distance(exec, shirt.model, shirt.state).crossings, 0);
}

}  // namespace
}  // namespace turgor

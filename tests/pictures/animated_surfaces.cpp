#include "turgor/pictures/animated_surfaces.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/four_kinds.hpp"
#include "turgor/pictures/outputs.hpp"
#include "turgor/pictures/run_scene.hpp"

namespace turgor {
namespace {

/// A triangle that rises.
WorldSnapshot rising_triangle(double time) {
  WorldSnapshot snapshot;
  BodySnapshot body;
  body.name = "sheet";
  const auto z = float(time);
  body.x = {{0, 0, z}, {1, 0, z}, {0, 1, z}}, body.triangles = {{0, 1, 2}}, body.wall_begin = 1;
  snapshot.bodies.push_back(body);
  snapshot.time = time;
  return snapshot;
}

/// Outputs of a run that writes animations only.
Outputs animation_outputs(const Scene& scene) {
  Outputs outputs;
  outputs.scene = &scene;
  outputs.folder = test::fresh_folder();
  return outputs;
}

Scene animation_scene(bool usd, bool gltf) {
  Scene scene;
  scene.output.usd = usd, scene.output.gltf = gltf, scene.output.meshes = false;
  return scene;
}

// A run collects snapshots for glTF until its file would be too large. It then frees them, warns once, and
// goes on.
TEST(AnimatedSurfaces, GltfEndsWhereItIsFull) {
  const Scene scene = animation_scene(false, true);
  Outputs outputs = animation_outputs(scene);
  constexpr std::uint64_t kMost = 1000;  // [bytes]
  for (int n = 0; n < 40; n++) ASSERT_TRUE(write_meshes(rising_triangle(0.1 * n), outputs, kMost)) << n;
  EXPECT_TRUE(outputs.animation_ended);
  EXPECT_TRUE(outputs.animation.surfaces.empty());
  finish_animation(outputs, kMost);
  EXPECT_EQ(test::names_in(outputs.folder), std::set<std::string>());
  EXPECT_TRUE(outputs.facts.files.empty());
  ASSERT_EQ(outputs.facts.warnings.size(), 1u);
  EXPECT_EQ(outputs.facts.warnings[0].find("no glTF: expected at most"), 0u) << outputs.facts.warnings[0];
}

// USD holds all snapshots, also where glTF is requested too and cannot.
TEST(AnimatedSurfaces, UsdIsWrittenWithoutGltf) {
  const Scene scene = animation_scene(true, true);
  Outputs outputs = animation_outputs(scene);
  for (int n = 0; n < 40; n++) ASSERT_TRUE(write_meshes(rising_triangle(0.1 * n), outputs, 1000));
  EXPECT_EQ(outputs.animation.times.size(), 40u);
  finish_animation(outputs, 1000);
  EXPECT_EQ(test::names_in(outputs.folder), std::set<std::string>{"surfaces.usda"});
  EXPECT_EQ(outputs.facts.files, std::vector<std::string>{"surfaces.usda"});
  EXPECT_EQ(outputs.facts.warnings.size(), 1u);
}

// A file that cannot be written is a warning each.
TEST(AnimatedSurfaces, FailedFilesAreWarnings) {
  const Scene scene = animation_scene(true, true);
  Outputs outputs = animation_outputs(scene);
  ASSERT_TRUE(write_meshes(rising_triangle(0), outputs));
  outputs.folder /= "gone";
  finish_animation(outputs);
  EXPECT_TRUE(outputs.facts.files.empty());
  ASSERT_EQ(outputs.facts.warnings.size(), 2u);
  EXPECT_EQ(outputs.facts.warnings[0].find("no USD: "), 0u) << outputs.facts.warnings[0];
  EXPECT_EQ(outputs.facts.warnings[1].find("no glTF: "), 0u) << outputs.facts.warnings[1];
}

// A run whose USD and glTF cannot be written keeps its other results and warns.
TEST(AnimatedSurfaces, FailureKeepsResultsOfRun) {
  namespace fs = std::filesystem;
  const fs::path folder = test::fresh_folder();
  const Scene scene =
      test::four_kinds_scene(folder, {"output.usd=true", "output.gltf=true", "output.video=false"});
  RunCallbacks callbacks;
  callbacks.frame = [&](const World&) {
    for (const std::string& name : test::names_in(folder))
      if (name.starts_with("."))  // the hidden folder of the run
        for (const char* file : {"surfaces.usda", "surfaces.glb"})
          fs::create_directories(folder / name / file / "no file");
    return true;
  };
  const Result<Json> report = run_scene(Exec(2), scene, {.out = folder / "ran"}, callbacks);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(fs::exists(folder / "ran/recording.h5"));
  const std::string warnings = (*report)["warnings"].dump(), files = (*report)["files"].dump();
  EXPECT_NE(warnings.find("no USD: "), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("no glTF: "), std::string::npos) << warnings;
  EXPECT_EQ(files.find("surfaces"), std::string::npos) << files;
}

// A body and a tool of the same name have surfaces of their own, with one sample a time each.
TEST(AnimatedSurfaces, ToolMayHaveNameOfBody) {
  WorldSnapshot snapshot;
  BodySnapshot body;
  body.name = "pad";
  body.x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, body.triangles = {{0, 1, 2}}, body.wall_begin = 1;
  ToolSnapshot tool;
  tool.name = "pad";
  tool.mesh = {body.x, body.triangles, {}, {}};
  snapshot.bodies.push_back(body), snapshot.tools.push_back(tool);
  SurfaceAnimation animation;
  for (const double time : {0.0, 0.1}) snapshot.time = time, add_surfaces(snapshot, animation);
  std::vector<std::string> names;
  for (const AnimatedSurface& surface : animation.surfaces) {
    names.push_back(surface.name);
    EXPECT_EQ(surface.samples.size(), 2u) << surface.name;
  }
  EXPECT_EQ(std::count(names.begin(), names.end(), "pad"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "pad tool"), 1);
}

}  // namespace
}  // namespace turgor

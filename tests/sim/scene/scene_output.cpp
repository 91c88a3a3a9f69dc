#include <gtest/gtest.h>

#include "tests/sim/scene/scene_error.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {
namespace {

std::string scene_with(const std::string& rest) {
  return "[body.torso]\nmodel = \"lattice\"\nct = { phantom = \"torso\" }\n[world]\nduration = 20\n" + rest;
}

// A scene is refused if it leaves more snapshots than glTF can hold. An interval is a whole number of frames:
// 0.024 s at 60 frames a second is one frame.
TEST(SceneOutput, GltfSnapshotsAreCounted) {
  const auto error = [](const std::string& every) {
    return test::error_of(scene_with("[output]\ngltf = true\nsnapshots = { every = " + every + " }\n"));
  };
  EXPECT_EQ(error("0.024"),
            "s.toml:7:8: output.gltf: expected at most 1000 snapshots for glTF, found 1201; raise "
            "output.snapshots.every, or use usd");
  EXPECT_EQ(error("0.03"), "no error") << "601 snapshots of every second frame";
  EXPECT_EQ(test::error_of(scene_with("[output]\nusd = true\nsnapshots = { every = 0.024 }\n")), "no error");
}

}  // namespace
}  // namespace turgor

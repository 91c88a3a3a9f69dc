// Recordings of rigid bodies.
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/sim/recording/recording.hpp"

namespace turgor {
namespace {

constexpr const char* kBoxUnderFinger =
    "[world]\nduration = 1\ngravity = [0, 0, -9.81]\n"
    "[body.box]\nmodel = \"rigid\"\nshape = { box = [0.04, 0.04, 0.02] }\nat = [0, 0, 0.01]\nmass = 0.2\n"
    "[contact.floor]\nbetween = [\"box\", \"ground\"]\n"
    "[tool.finger]\nbody = \"box\"\nshape = { sphere = 0.01 }\n"
    "path = [[0, 0, 0, 0.035], [0.1, 0.002, 0.001, 0.0295], [1, 0.002, 0.001, 0.0295]]\n";

World world_of(const Scene& scene) {
  Result<World> world = load_world(Exec(1), scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}

// A replay draws a tool on a rigid body with its name, shape, pose and force.
TEST(RecordingRigid, Replay_DrawsTool) {
  const Exec exec(1);
  const std::filesystem::path file = test::fresh_folder() / "r.h5";
  const Result<Scene> scene = parse_scene(kBoxUnderFinger, "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  // record one snapshot after ten frames
  World world = world_of(*scene);
  Result<RecordingWriter> writer = RecordingWriter::create(file, *scene, world);
  ASSERT_TRUE(writer) << writer.error().message;
  for (int frame = 0; frame < 10; frame++) ASSERT_TRUE(step(exec, world));
  WorldSnapshot run, replay;
  show(exec, world, run);
  ASSERT_TRUE(writer->add_snapshot(world, run));
  ASSERT_TRUE(writer->finish(world, run, make_pressed(world), "{}"));
  // restore it
  const Result<Recording> recording = Recording::open(file);
  ASSERT_TRUE(recording) << recording.error().message;
  World drawn = world_of(*scene);
  const Status restored = recording->restore(exec, 0, drawn, replay);
  ASSERT_TRUE(restored) << restored.error().message;
  ASSERT_EQ(replay.tools.size(), 1U);
  const ToolSnapshot &a = run.tools[0], &b = replay.tools[0];
  EXPECT_EQ(a.name, "finger");
  EXPECT_EQ(b.name, a.name);
  EXPECT_TRUE(b.body == a.body);
  EXPECT_GT(norm(a.force), 0.1);
  EXPECT_EQ(b.force, a.force);
  EXPECT_EQ(b.pose.position, a.pose.position);
  EXPECT_EQ(b.mesh.vertices, a.mesh.vertices);
}

}  // namespace
}  // namespace turgor

#include "turgor/sim/run.hpp"

#include "tests/sim/four_kinds.hpp"

namespace turgor {
namespace {

// Events are called once per frame, snapshot and requested picture.
TEST(Simulate, CallsEventsPerFrameAndSnapshot) {
  const Exec exec(2);
  const Scene scene = test::four_kinds_scene(test::fresh_folder(), {"output.snapshots.every=0.1"});
  World world = test::block_world(exec, scene);
  std::vector<int> frames, snapshots, pictures;
  double finished = 0;
  RunEvents events;
  events.progress = [&](double fraction) { finished = fraction; };
  events.frame = [&](const World& now) { return frames.push_back(now.frame), true; };
  events.snapshot = [&](const World& now, const WorldSnapshot& snapshot) -> Status {
    EXPECT_EQ(now.frame, snapshot.frame);
    snapshots.push_back(snapshot.frame);
    return Done{};
  };
  events.picture = [&](const WorldSnapshot& snapshot) -> Status {
    return pictures.push_back(snapshot.frame), Done{};
  };
  events.wants_picture = [](const World& w) { return w.frame % 4 == 0; };
  const Result<Simulated> done = simulate(exec, scene, world, events);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(frames.size(), 15u);
  EXPECT_EQ(snapshots, (std::vector<int>{0, 5, 10, 15}));
  EXPECT_EQ(pictures, (std::vector<int>{4, 8, 12}));
  EXPECT_EQ(finished, 1);
  EXPECT_TRUE(done->stopped.empty());
  EXPECT_EQ(done->snapshot.frame, 15);
  EXPECT_EQ(done->measures.frame_seconds.size(), 15u);
}

// A frame event stops the run, which ends with a snapshot.
TEST(Simulate, FrameEventStopsRun) {
  const Exec exec(2);
  const Scene scene = test::block_scene(test::fresh_folder());
  World world = test::block_world(exec, scene);
  std::vector<int> snapshots;
  RunEvents events;
  events.frame = [](const World& now) { return now.frame < 3; };
  events.snapshot = [&](const World&, const WorldSnapshot& snapshot) -> Status {
    return snapshots.push_back(snapshot.frame), Done{};
  };
  const Result<Simulated> done = simulate(exec, scene, world, events);
  ASSERT_TRUE(done);
  EXPECT_EQ(world.frame, 3);
  EXPECT_EQ(snapshots, (std::vector<int>{0, 3}));
  EXPECT_EQ(done->stopped, "stopped after 0.060 s of 0.2 s, on request");
  EXPECT_TRUE(done->finite);
}

// An error of a snapshot event ends the run with that error.
TEST(Simulate, SnapshotErrorEndsRun) {
  const Exec exec(2);
  const Scene scene = test::block_scene(test::fresh_folder());
  World world = test::block_world(exec, scene);
  RunEvents events;
  events.snapshot = [](const World&, const WorldSnapshot& snapshot) -> Status {
    return snapshot.frame < 5 ? Status(Done{}) : Status(Error{"the disk is full"});
  };
  const Result<Simulated> done = simulate(exec, scene, world, events);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message, "the disk is full");
  EXPECT_EQ(world.frame, 5);
}

/// Final bits of a run with snapshots and pictures at the given intervals.
struct Ended {
  std::uint64_t hash = 0;
  double pressed_volume = 0, gape = 0;
  std::vector<double> forces;
};
Ended run_with_outputs(const std::filesystem::path& folder, const std::string& every, int picture_every) {
  const Exec exec(2);
  const Scene scene = test::four_kinds_scene(folder, {"output.snapshots.every=" + every});
  World world = test::block_world(exec, scene);
  RunEvents events;
  events.picture = [](const WorldSnapshot&) -> Status { return Done{}; };
  events.wants_picture = [picture_every](const World& w) {
    return picture_every > 0 && w.frame % picture_every == 0;
  };
  const Result<Simulated> done = simulate(exec, scene, world, events);
  EXPECT_TRUE(done);
  Ended ended{state_hash(world), world.rhombus_bodies[0].pressed_volume, 0, {}};
  ended.gape = done->measures.cuts[0].wound.gape_max;
  for (const Pressed& pressed : done->measures.pressed) {
    ended.forces.push_back(pressed.force);
    ended.forces.push_back(pressed.time);
    for (const Vec3 u : pressed.body.displacement) ended.forces.push_back(norm(u));
  }
  return ended;
}

// The rate of pictures and snapshots changes neither the bits nor the measures.
TEST(Simulate, SnapshotRateKeepsBits) {
  const std::filesystem::path folder = test::fresh_folder();
  const Ended seldom = run_with_outputs(folder, "10", 0);
  for (const auto& [every, pictures] : {std::pair("0.02", 1), std::pair("0.06", 2), std::pair("10", 7)}) {
    const Ended often = run_with_outputs(folder, every, pictures);
    EXPECT_EQ(often.hash, seldom.hash) << every;
    EXPECT_EQ(often.pressed_volume, seldom.pressed_volume) << every;
    EXPECT_EQ(often.gape, seldom.gape) << every;
    EXPECT_EQ(often.forces, seldom.forces) << every;
  }
  EXPECT_GT(seldom.pressed_volume, 0);
  EXPECT_GT(seldom.gape, 1e-4);
}

// Every shipped scene takes its first steps.
TEST(Simulate, ShippedScenesBegin) {
  const Exec exec(2);
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(TURGOR_SOURCE_DIR "/scenes")) {
    if (file.path().extension() != ".toml") continue;
    Result<Scene> scene = read_scene(file.path());
    ASSERT_TRUE(scene) << scene.error().message;
    for (SfemScene& body : scene->sfem_bodies) body.cached = false;
    Result<World> world = load_world(exec, *scene);
    ASSERT_TRUE(world) << world.error().message;
    RunEvents events;
    events.frame = [](const World& now) { return now.frame < 3; };
    const Result<Simulated> done = simulate(exec, *scene, *world, events);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(done->finite) << file.path() << ": " << done->stopped;
    count++;
  }
  EXPECT_GE(count, 15);
}

}  // namespace
}  // namespace turgor

#include "turgor/sim/live/driven_ticks.hpp"

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/four_kinds.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

/// A world of every kind whose finger slides over the pad so far that its patch must follow; the others go
/// where the scene has them.
struct Led {
  World world;
  std::vector<TouchingTool> paths;
  LedTicks led;
  std::vector<Vec3d> haptic;  // of every tool in every tick, in turn [N]

  explicit Led(const Scene& scene, int threads = 2) : exec(threads) {
    Result<World> made = load_world(exec, scene);
    EXPECT_TRUE(made) << made.error().message;
    world = std::move(*made);
    paths = world.tools;
    led = begin_led(world);
  }
  void extrapolate(int ticks) {
    std::vector<contact::ToolReading> readings(world.tools.size());
    for (int n = 0; n < ticks; n++) {
      const double time = time_of(led) + kTick;
      std::vector<contact::ToolCommand> commands;
      for (const TouchingTool& tool : paths) commands.push_back(command_at(tool, time));
      if (slides) commands[0].pose.position = {0.012 + 0.15 * time, 0.03, 0.034};
      const Status done = tick_led(exec, world, led, commands, readings);
      ASSERT_TRUE(done) << done.error().message;
      for (const contact::ToolReading& reading : readings) haptic.push_back(reading.force);
    }
  }
  std::uint64_t hash() const { return state_hash(world); }

  Exec exec;
  bool slides = true;
};

TEST(LedTicks, AToolThatIsLedAlongItsPathFeelsWhatItFeelsOnIt) {
  const Scene scene = test::four_kinds_scene(test::fresh_folder());
  Led led(scene);
  led.slides = false;
  led.extrapolate(150);
  Led path(scene);
  end_led(path.world);
  for (int frame = 0; frame < 7; frame++) ASSERT_TRUE(step(path.exec, path.world));
  const TouchLog &haptic = led.world.tools[1].samples, &expected = path.world.tools[1].samples;
  double largest = 0;
  for (std::size_t n = 0; n < 140; n++) {  // the ball is on the liver, whose ticks need nothing of the frames
    EXPECT_EQ(haptic[n].force, expected[n].force) << n;
    largest = std::max(largest, norm(expected[n].force));
  }
  EXPECT_GT(largest, 0.05);
  const Vec3d finger = led.world.tools[0].samples[130].force, wanted = path.world.tools[0].samples[130].force;
  EXPECT_GT(norm(wanted), 0.01);
  EXPECT_LT(norm(finger - wanted), 0.05 * norm(wanted))
      << finger.z << " " << wanted.z;  // cloth a frame later
  EXPECT_EQ(led.world.frame, 7);
}

TEST(LedTicks, AreTheSameBitsOnAnyNumberOfThreads) {
  const Scene scene = test::four_kinds_scene(test::fresh_folder());
  Led one(scene, 1), three(scene, 3);
  one.extrapolate(200), three.extrapolate(200);
  EXPECT_EQ(one.hash(), three.hash());
  EXPECT_GT(one.world.sfem_bodies[0].rebuilds.size(), 0u) << "the patch did not follow";
}

/// A block, and a sheet that is held all around, each beside a ball on its left.
World beside_tools(const std::filesystem::path& folder, const Exec& exec) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const Result<Scene> scene = parse_scene(R"(
[world]
frame_rate = 50
[body.block]
model = "lattice"
ct = "block.nii"
block = 2
fixed = "bone"
[body.sheet]
model = "cloth"
sheet = { corner = [0.2, 0, -0.05], side = [0, 0.1, 0], up = [0, 0, 0.1], columns = 12, rows = 12 }
fabric = { law = "sheet" }
solver = { method = "blocks" }
hold.left = { box = [[-1, -1, -1], [1, 0.001, 1]] }
hold.right = { box = [[-1, 0.099, -1], [1, 1, 1]] }
[tool.ball]
body = "block"
shape = { sphere = 0.014 }
path = [[0, -0.09, 0, 0]]
[tool.other]
body = "sheet"
shape = { sphere = 0.014 }
path = [[0, 0.17, 0.05, 0]]
)",
                                          folder / "scene.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}
/// How far anything of either body has moved [m].
double farthest(const World& world) {
  double farthest = 0;
  const lattice::State& block = world.lattice_bodies[0].state;
  for (std::size_t s = 0; s < block.u.x.size(); s++) farthest = std::max(farthest, norm(Vec3d(block.u[s])));
  const cloth::Model& sheet = world.cloth_bodies[0].model;
  for (std::size_t v = 0; v < sheet.x_rest.size(); v++)
    farthest = std::max(farthest, norm(Vec3d(world.cloth_bodies[0].state->x[v]) - Vec3d(sheet.x_rest[v])));
  return farthest;
}

TEST(LedTicks, AToolThatIsPutElsewhereTakesNothingAlongOnItsWay) {
  const Exec exec(2);
  World world = beside_tools(test::fresh_folder(), exec);
  LedTicks led = begin_led(world);
  std::vector<contact::ToolReading> readings(2);
  double haptic = 0;
  for (int tick = 0; tick < 200; tick++) {
    std::vector<contact::ToolCommand> commands(2);  // to and fro, every 36 ms, through the middles of both
    const double side = tick / 36 % 2 == 0 ? -1 : 1;
    commands[0].pose.position = {0.09 * side, 0, 0};
    commands[1].pose.position = {0.2 + 0.03 * side, 0.05, 0};
    ASSERT_TRUE(tick_led(exec, world, led, commands, readings));
    for (const contact::ToolReading& reading : readings) haptic = std::max(haptic, norm(reading.force));
  }
  EXPECT_EQ(haptic, 0);
  EXPECT_LT(farthest(world), 1e-3) << "what the skin's tension does alone";
}

TEST(LedTicks, AToolThatRacesThroughABodyLeavesItWhole) {
  const Exec exec(2);
  for (const double speed : {1.0, 5.0, 20.0}) {  // [m/s]
    World world = beside_tools(test::fresh_folder(), exec);
    LedTicks led = begin_led(world);
    std::vector<contact::ToolReading> readings(2);
    double worst = 0;
    for (int tick = 0; tick < 2000; tick++) {
      std::vector<contact::ToolCommand> commands(2);
      const double way = std::min(speed * kTick * tick, 0.2);
      commands[0].pose.position = {-0.09 + way, 0, 0};
      commands[1].pose.position = {0.17, 0.05, 0};
      ASSERT_TRUE(tick_led(exec, world, led, commands, readings));
      worst = std::max(worst, farthest(world));
    }
    EXPECT_LT(worst, 0.24) << speed << " m/s: no farther than the ball, and its size";
    EXPECT_LT(farthest(world), 4e-3) << speed << " m/s: half a step, two seconds later";
  }
}

TEST(WorldState, ACopyGoesOnToTheSameBitsWhileAPatchIsBuilt) {
  Led led(test::four_kinds_scene(test::fresh_folder()));
  int building = 0;
  for (int n = 0; n < 20; n++) {
    led.extrapolate(10);
    if (!led.world.sfem_bodies[0].worker || !led.world.sfem_bodies[0].worker->is_busy()) continue;
    building++;
    Led copy = led;
    copy.world = copy_of(led.world);
    copy.extrapolate(45), led.extrapolate(45);
    EXPECT_EQ(copy.hash(), led.hash());
    EXPECT_EQ(copy.haptic, led.haptic);
    break;
  }
  EXPECT_EQ(building, 1);
}

TEST(WorldState, GoesBackToWhereItWas) {
  Led led(test::four_kinds_scene(test::fresh_folder()));
  led.extrapolate(85);
  const WorldState state = state_of(led.world);
  const LedTicks ticks = led.led;
  const std::uint64_t before = led.hash();
  led.haptic.clear();
  led.extrapolate(75);
  const std::uint64_t after = led.hash();
  const std::vector<Vec3d> haptic = led.haptic;
  EXPECT_NE(before, after);
  for (int time = 0; time < 2; time++) {
    set_state(led.world, state);
    led.led = ticks;
    EXPECT_EQ(led.hash(), before);
    led.haptic.clear();
    led.extrapolate(75);
    EXPECT_EQ(led.hash(), after);
    EXPECT_EQ(led.haptic, haptic);
  }
  EXPECT_FALSE(led.world.lattice_bodies[0].state->cut_edges.empty());
}

TEST(WorldState, HoldsNoModel) {
  Led led(test::four_kinds_scene(test::fresh_folder()));
  const WorldState state = state_of(led.world);
  EXPECT_TRUE(state.world.sfem_bodies[0].model.body.mesh.vertices.empty());
  EXPECT_TRUE(state.world.lattice_bodies[0].ct.samples.empty());
  EXPECT_FALSE(led.world.lattice_bodies[0].ct.samples.empty());
  EXPECT_FALSE(led.world.sfem_bodies[0].model.body.mesh.vertices.empty());
}

}  // namespace
}  // namespace turgor

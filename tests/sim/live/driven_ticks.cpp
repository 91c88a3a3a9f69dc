#include "turgor/sim/live/driven_ticks.hpp"

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/four_kinds.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

/// A world of every model whose finger slides over the pad so far that its patch must follow; the other tools
/// follow the scene.
struct DrivenWorld {
  World world;
  std::vector<TouchingTool> paths;
  DrivenTicks driven;
  std::vector<Vec3d> haptic;  // of every tool in every tick [N]

  explicit DrivenWorld(const Scene& scene, int threads = 2) : exec(threads) {
    Result<World> made = load_world(exec, scene);
    EXPECT_TRUE(made) << made.error().message;
    world = std::move(*made);
    paths = world.tools;
    driven = begin_driven(world);
  }
  void advance(int ticks) {
    std::vector<contact::ToolReading> readings(world.tools.size());
    for (int n = 0; n < ticks; n++) {
      const double time = driven.began + double(driven.done + 1) * kTick;  // rounded as in a run
      std::vector<contact::ToolCommand> commands;
      for (const TouchingTool& tool : paths) commands.push_back(command_at(tool, time));
      if (slides) commands[0].pose.position = {0.012 + 0.15 * time, 0.03, 0.034};
      const Status done = tick_driven(exec, world, driven, commands, readings);
      ASSERT_TRUE(done) << done.error().message;
      for (const contact::ToolReading& reading : readings) haptic.push_back(reading.force);
    }
  }
  std::uint64_t hash() const { return state_hash(world); }

  Exec exec;
  bool slides = true;
};

// A tool commanded along its path has the forces of the run with that path.
TEST(DrivenTicks, CommandedToolMatchesPath) {
  const Scene scene = test::four_kinds_scene(test::fresh_folder());
  DrivenWorld driven(scene);
  driven.slides = false;
  driven.advance(150);
  DrivenWorld path(scene);
  end_driven(path.world);
  for (int frame = 0; frame < 7; frame++) ASSERT_TRUE(step(path.exec, path.world));
  const TouchLog &haptic = driven.world.tools[1].samples, &expected = path.world.tools[1].samples;
  double largest = 0;
  for (std::size_t n = 0; n < 140; n++) {  // the ball is on the liver, whose ticks need no frames
    EXPECT_EQ(haptic[n].force, expected[n].force) << n;
    largest = std::max(largest, norm(expected[n].force));
  }
  EXPECT_GT(largest, 0.05);
  const Vec3d finger = driven.world.tools[0].samples[130].force,
              wanted = path.world.tools[0].samples[130].force;
  EXPECT_GT(norm(wanted), 0.01);
  EXPECT_LT(norm(finger - wanted), 0.05 * norm(wanted))
      << finger.z << " " << wanted.z;  // cloth is one frame later
  EXPECT_EQ(driven.world.frame, 7);
}

// Driven ticks have the same bits on 1 and 3 threads.
TEST(DrivenTicks, EqualBitsOnAnyThreads) {
  const Scene scene = test::four_kinds_scene(test::fresh_folder());
  DrivenWorld one(scene, 1), three(scene, 3);
  one.advance(200), three.advance(200);
  EXPECT_EQ(one.hash(), three.hash());
  EXPECT_GT(one.world.sfem_bodies[0].rebuilds.size(), 0u) << "the patch did not follow";
}

// Commands from the paths are those before the ticks, although frames give a tool on a lattice the motion of
// the ticks.
TEST(DrivenTicks, PathsAreThoseBeforeTicks) {
  const Exec exec(1);
  World world = test::block_world(exec, test::four_kinds_scene(test::fresh_folder()));
  const std::vector<TouchingTool> paths = world.tools;
  DrivenTicks driven = begin_driven(world);
  std::vector<contact::ToolReading> readings(paths.size());
  std::vector<contact::ToolCommand> commands;
  for (const TouchingTool& tool : paths) commands.push_back(command_at(tool, 0));
  for (int tick = 0; tick < 60; tick++) ASSERT_TRUE(tick_driven(exec, world, driven, commands, readings));
  const contact::Pose start = commands[test::kTip].pose;
  EXPECT_GT(norm(command_at(paths[test::kTip], 0.08).pose.position - start.position), 1e-3);
  for (std::size_t t = 0; t < paths.size(); t++)
    for (const double time : {0.0, 0.08, 0.13}) {
      const contact::Pose wanted = command_at(paths[t], time).pose,
                          found = path_command(driven, t, time).pose;
      EXPECT_EQ(found.position, wanted.position) << t;
      EXPECT_EQ(found.axes.column[0], wanted.axes.column[0]) << t;
    }
}

/// A block, and a sheet that is held on all sides, each with a ball to its left.
World world_beside_tools(const std::filesystem::path& folder, const Exec& exec,
                         const std::vector<std::string>& overrides = {}) {
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
solver = { method = "two_level" }
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
                                          folder / "scene.toml", overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}
/// Surface of the block in its CT.
lattice::BodySurface block_surface(const World& world) {
  const LatticeBody& block = world.lattice_bodies[0];
  return lattice::build_surface(block.model, block.state->cuts, &block.ct);
}
/// Largest displacement of a point of the block's surface [m].
double farthest_of_surface(const World& world, const lattice::BodySurface& surface) {
  double farthest = 0;
  const LatticeBody& block = world.lattice_bodies[0];
  for (int v = 0; v < int(surface.rest.size()); v++)
    farthest =
        std::max(farthest, norm(Vec3d(lattice::vertex_displacement(block.model, *block.state, surface, v))));
  return farthest;
}
/// Largest displacement of either body [m]: of the nodes in the block, and of the cloth. Rim nodes are
/// outside the block; they are coefficients of the displacement between them and the block.
double farthest(const World& world) {
  double farthest = 0;
  const lattice::Model& model = world.lattice_bodies[0].model;
  const lattice::State& block = world.lattice_bodies[0].state;
  for (std::size_t s = 0; s < block.motion.u.x.size(); s++)
    if (lattice::is_body(model.anatomy.tissue[s]))
      farthest = std::max(farthest, norm(Vec3d(block.motion.u[s])));
  const cloth::Model& sheet = world.cloth_bodies[0].model;
  for (std::size_t v = 0; v < sheet.x_rest.size(); v++)
    farthest = std::max(farthest, norm(Vec3d(world.cloth_bodies[0].state->x[v]) - Vec3d(sheet.x_rest[v])));
  return farthest;
}

// A teleported tool does not move the bodies between its two positions.
TEST(DrivenTicks, TeleportedToolMovesNothing) {
  const Exec exec(2);
  World world = world_beside_tools(test::fresh_folder(), exec);
  DrivenTicks driven = begin_driven(world);
  std::vector<contact::ToolReading> readings(2);
  double haptic = 0;
  for (int tick = 0; tick < 200; tick++) {
    std::vector<contact::ToolCommand> commands(2);  // back and forth through the middles of both, every 36 ms
    const double side = tick / 36 % 2 == 0 ? -1 : 1;
    commands[0].pose.position = {0.09 * side, 0, 0};
    commands[1].pose.position = {0.2 + 0.03 * side, 0.05, 0};
    ASSERT_TRUE(tick_driven(exec, world, driven, commands, readings));
    for (const contact::ToolReading& reading : readings) haptic = std::max(haptic, norm(reading.force));
  }
  EXPECT_EQ(haptic, 0);
  EXPECT_LT(std::max(farthest(world), farthest_of_surface(world, block_surface(world))), 1e-3)
      << "m: displacement by the skin's tension only";
}

/// A body recovers after a tool passes through it at up to 20 m/s. No node of it moves by more than `most`
/// [m]. The surface of whole cells lies outside the nodes and is thrown further.
void expect_recovery_from_fast_tool(const std::string& partial_cells, double most) {
  const Exec exec(2);
  for (const double speed : {1.0, 5.0, 20.0}) {  // [m/s]
    World world =
        world_beside_tools(test::fresh_folder(), exec, {"body.block.tissue.partial_cells=" + partial_cells});
    const lattice::BodySurface surface = block_surface(world);
    DrivenTicks driven = begin_driven(world);
    std::vector<contact::ToolReading> readings(2);
    double worst = 0, worst_of_surface = 0;
    int frame = 0;
    for (int tick = 0; tick < 2000; tick++) {
      std::vector<contact::ToolCommand> commands(2);
      const double distance = std::min(speed * kTick * tick, 0.2);
      commands[0].pose.position = {-0.09 + distance, 0, 0};
      commands[1].pose.position = {0.17, 0.05, 0};
      ASSERT_TRUE(tick_driven(exec, world, driven, commands, readings));
      if (world.frame == frame) continue;
      frame = world.frame, worst = std::max(worst, farthest(world));
      worst_of_surface = std::max(worst_of_surface, farthest_of_surface(world, surface));
    }
    EXPECT_LT(worst, most) << speed << " m/s";
    std::printf("%g m/s: nodes %.1f mm, surface %.1f mm while it passes\n", speed, 1e3 * worst,
                1e3 * worst_of_surface);
    EXPECT_LT(worst_of_surface, 0.29) << speed << " m/s";
    EXPECT_LT(std::max(farthest(world), farthest_of_surface(world, surface)), 4e-3)
        << speed << " m/s: half a cell, two seconds later";
  }
}

// Nodes of whole cells move by the ball's path and size at most.
TEST(DrivenTicks, FastToolKeepsBodyIntact) { expect_recovery_from_fast_tool("false", 0.24); }

// Partial cells are thrown further, since the sweeps of these frames do not converge (partial-cells.md,
// Limits).
TEST(DrivenTicks, FastToolKeepsPartialCellsIntact) { expect_recovery_from_fast_tool("true", 0.29); }

// A copy of a world continues to the same bits, even while a patch is built.
TEST(DrivenTicks, CopyDuringPatchBuildIsExact) {
  DrivenWorld driven(test::four_kinds_scene(test::fresh_folder()));
  int building = 0;
  for (int n = 0; n < 20; n++) {
    driven.advance(10);
    if (!driven.world.sfem_bodies[0].worker || !driven.world.sfem_bodies[0].worker->is_busy()) continue;
    building++;
    DrivenWorld copy = driven;
    copy.world = copy_of(driven.world);
    copy.advance(45), driven.advance(45);
    EXPECT_EQ(copy.hash(), driven.hash());
    EXPECT_EQ(copy.haptic, driven.haptic);
    break;
  }
  EXPECT_EQ(building, 1);
}

// A restored state repeats the same bits.
TEST(DrivenTicks, RestoredStateRepeatsBits) {
  DrivenWorld driven(test::four_kinds_scene(test::fresh_folder()));
  driven.advance(85);
  const WorldState state = state_of(driven.world);
  const DrivenTicks ticks = driven.driven;
  const std::uint64_t before = driven.hash();
  driven.haptic.clear();
  driven.advance(75);
  const std::uint64_t after = driven.hash();
  const std::vector<Vec3d> haptic = driven.haptic;
  EXPECT_NE(before, after);
  for (int time = 0; time < 2; time++) {
    set_state(driven.world, state);
    driven.driven = ticks;
    EXPECT_EQ(driven.hash(), before);
    driven.haptic.clear();
    driven.advance(75);
    EXPECT_EQ(driven.hash(), after);
    EXPECT_EQ(driven.haptic, haptic);
  }
  EXPECT_FALSE(driven.world.lattice_bodies[0].state->cuts.edges.empty());
}

// The state of a world does not hold its models.
TEST(DrivenTicks, StateHoldsNoModel) {
  DrivenWorld driven(test::four_kinds_scene(test::fresh_folder()));
  const WorldState state = state_of(driven.world);
  EXPECT_TRUE(state.world.sfem_bodies[0].model.body.mesh.vertices.empty());
  EXPECT_TRUE(state.world.lattice_bodies[0].ct.samples.empty());
  EXPECT_FALSE(driven.world.lattice_bodies[0].ct.samples.empty());
  EXPECT_FALSE(driven.world.sfem_bodies[0].model.body.mesh.vertices.empty());
}

}  // namespace
}  // namespace turgor

#include "turgor/sim/snapshot.hpp"

#include <set>

#include "tests/sim/four_kinds.hpp"
#include "turgor/sim/pressed.hpp"

namespace turgor {
namespace {

World four_kinds_world(const Exec& exec, const std::filesystem::path& folder) {
  return test::block_world(exec, test::four_kinds_scene(folder));
}

// A snapshot holds every body, tool and obstacle of a world with all models.
TEST(WorldSnapshot, HoldsEveryBodyAndTool) {
  const Exec exec(2);
  World world = four_kinds_world(exec, test::fresh_folder());
  for (int frame = 0; frame < 6; frame++) ASSERT_TRUE(step(exec, world));
  WorldSnapshot snapshot;
  show(exec, static_cast<const World&>(world), snapshot);
  ASSERT_EQ(snapshot.bodies.size(), kModelCount);
  std::set<BodyKind> kinds;
  for (const BodySnapshot& body : snapshot.bodies) {
    SCOPED_TRACE(body.name);
    kinds.insert(body.id.kind);
    ASSERT_GT(body.triangles.size(), 50u);
    ASSERT_EQ(body.x.size(), body.rest.size());
    ASSERT_EQ(body.x.size(), body.displacement.size());
    ASSERT_EQ(body.x.size(), body.normals.size());
    for (std::size_t v = 0; v < body.x.size(); v++) {
      ASSERT_NEAR(norm(body.x[v] - body.rest[v] - body.displacement[v]), 0, 1e-7) << v;
      ASSERT_GE(body.rest[v].z, body.box.low.z - 0.02);
    }
    for (const Int3 t : body.triangles)
      for (int corner = 0; corner < 3; corner++) ASSERT_LT(std::size_t(t[corner]), body.x.size());
  }
  EXPECT_EQ(kinds.size(), kModelCount);
  EXPECT_EQ(body_snapshot(snapshot, {BodyKind::kLattice, 0}).look, Look::kSkin);
  EXPECT_EQ(body_snapshot(snapshot, {BodyKind::kLattice, 0}).stretch.size(),
            body_snapshot(snapshot, {BodyKind::kLattice, 0}).x.size());
  EXPECT_FALSE(body_snapshot(snapshot, {BodyKind::kSfem, 0}).pressure.empty());
  EXPECT_TRUE(body_snapshot(snapshot, {BodyKind::kRhombus, 0}).pressure.empty())
      << "this model has no pressure";
  ASSERT_EQ(snapshot.tools.size(), 3u);
  for (std::size_t t = 0; t < 3; t++) {
    EXPECT_EQ(snapshot.tools[t].name, world.tools[t].name);
    EXPECT_EQ(snapshot.tools[t].force, world.tools[t].samples.back().force);
    EXPECT_NEAR(norm(snapshot.tools[t].pose.position - world.tools[t].samples.back().position), 0, 1e-12);
    EXPECT_FALSE(snapshot.tools[t].mesh.triangles.empty());
    EXPECT_EQ(tools_on(snapshot, snapshot.tools[t].body).size(), 1u);
  }
  EXPECT_EQ(snapshot.obstacles.size(), 1u) << "the floor; the pad is a body";
  EXPECT_NEAR(snapshot.time, 0.12, 1e-12);
}

// Taking snapshots does not change the simulation.
TEST(WorldSnapshot, ShowKeepsStateBits) {
  const std::filesystem::path folder = test::fresh_folder();
  const Exec exec(2);
  World seen = four_kinds_world(exec, folder), unseen = four_kinds_world(exec, folder);
  WorldSnapshot snapshot;
  for (int frame = 0; frame < 12; frame++) {
    for (int time = 0; time <= frame % 3; time++) show(exec, seen, snapshot);
    ASSERT_TRUE(step(exec, seen));
    ASSERT_TRUE(step(exec, unseen));
    ASSERT_EQ(state_hash(seen), state_hash(unseen)) << "frame " << frame;
  }
  EXPECT_GT(seen.rhombus_bodies[0].pressed_volume, 0);
  EXPECT_EQ(seen.rhombus_bodies[0].pressed_volume, unseen.rhombus_bodies[0].pressed_volume);
}

// A snapshot reuses its memory.
TEST(WorldSnapshot, ReusesMemory) {
  const Exec exec(1);
  World world = four_kinds_world(exec, test::fresh_folder());
  for (int frame = 0; frame < 8; frame++) ASSERT_TRUE(step(exec, world));  // the cut is complete
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  std::vector<const Vec3*> before, after;
  for (const BodySnapshot& body : snapshot.bodies) before.push_back(body.x.data());
  for (int time = 0; time < 3; time++) show(exec, world, snapshot);
  for (const BodySnapshot& body : snapshot.bodies) after.push_back(body.x.data());
  EXPECT_EQ(before, after);
}

// A lattice without tools has the walls of its cut in the snapshot.
TEST(WorldSnapshot, CutLatticeHasWalls) {
  const Exec exec(1);
  const std::filesystem::path folder = test::fresh_folder();
  World world = test::block_world(exec, test::block_scene(folder));
  WorldSnapshot snapshot;
  show(exec, world, snapshot);
  EXPECT_EQ(snapshot.bodies[0].wall_begin, snapshot.bodies[0].triangles.size()) << "no walls before the cut";
  for (int frame = 0; frame < 8; frame++) ASSERT_TRUE(step(exec, world));
  show(exec, world, snapshot);
  EXPECT_LT(snapshot.bodies[0].wall_begin, snapshot.bodies[0].triangles.size());
  WorldSnapshot fresh;
  show(exec, world, fresh);
  EXPECT_EQ(snapshot.bodies[0].x, fresh.bodies[0].x) << "data of the previous frame is not stale";
}

// A pressed body is stored at the largest force of its tools.
TEST(WorldSnapshot, PressedBodyHasLargestForce) {
  const Exec exec(1);
  World world = four_kinds_world(exec, test::fresh_folder());
  std::vector<Pressed> pressed = make_pressed(world);
  ASSERT_EQ(pressed.size(), 5u) << "bodies that support contact; no tool touches the last two";
  EXPECT_EQ(pressed[3].id.kind, BodyKind::kCloth);
  EXPECT_EQ(pressed[4].id.kind, BodyKind::kRigid);
  std::vector<double> largest(3);
  for (int frame = 0; frame < 15; frame++) {
    ASSERT_TRUE(step(exec, world));
    update_pressed(exec, world, pressed);
    for (std::size_t n = 0; n < 3; n++)
      for (const TouchingTool& tool : world.tools)
        if (tool.body == pressed[n].id) largest[n] = std::max(largest[n], norm(tool.samples.back().force));
  }
  for (std::size_t n = 0; n < 3; n++) {
    EXPECT_GT(largest[n], 0) << pressed[n].body.name;
    EXPECT_DOUBLE_EQ(pressed[n].force, largest[n]) << pressed[n].body.name;
    ASSERT_EQ(pressed[n].tools.size(), 1u);
    EXPECT_DOUBLE_EQ(norm(pressed[n].tools[0].force), largest[n]);
    EXPECT_LT(pressed[n].time, time_of(world)) << "the tools have left the bodies";
  }
}

// A body id visits the body that it names, and the loop visits every body once.
TEST(WorldSnapshot, BodyIdVisitsEveryBodyOnce) {
  const Exec exec(1);
  World world = four_kinds_world(exec, test::fresh_folder());
  std::vector<std::string> names;
  for_each_body(world, [&](BodyId id, auto& body) {
    names.push_back(body.name);
    EXPECT_EQ(visit_body(world, id, [](const auto& same) { return same.name; }), body.name);
    EXPECT_EQ(visit_body(world, id, [](const auto& same) { return static_cast<const void*>(&same); }), &body);
  });
  EXPECT_EQ(names, (std::vector<std::string>{"pad", "liver", "block", "sheet", "weight"}));
  EXPECT_EQ(touched_body(world, {BodyKind::kRhombus, 0}).tool_indices, std::vector<int>{1});
  EXPECT_EQ(rest_surface(world, {BodyKind::kCloth, 0}).triangles.size(), 2u * 12 * 12);
}

}  // namespace
}  // namespace turgor

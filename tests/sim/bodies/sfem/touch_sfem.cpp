#include <cmath>
#include <set>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/sim/bodies/sfem/follow_tools.hpp"
#include "turgor/sim/recording/recording.hpp"
#include "turgor/sim/recording/recording_touch.hpp"
#include "turgor/sim/report/forces_csv.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/report/report_touch.hpp"
#include "turgor/sim/smooth_snapshot.hpp"

namespace turgor {
namespace {

using test::body_scene;
using test::sfem_world;

World run_world(const Exec& exec, const Scene& scene) {
  World world = sfem_world(exec, scene);
  for (int frame = 0; frame < frame_count(scene); frame++) EXPECT_TRUE(step(exec, world));
  return world;
}

BodySnapshot shown_now(const Exec& exec, const World& world) {
  BodySnapshot snapshot;
  show(exec, world.sfem_bodies[0], snapshot);
  return snapshot;
}

/// Largest force on the tool [N].
double largest_force(const World& world) {
  double largest = 0;
  for (const ForceSample& s : world.tools[0].samples) largest = std::max(largest, norm(s.force));
  return largest;
}

// Ticks are milliseconds at any frame rate.
TEST(TouchSfem, TicksAreMilliseconds) {
  const auto folder = test::fresh_folder();
  for (const char* rate : {"60", "77", "1000"}) {
    const World world = run_world(
        Exec(1), body_scene(folder, "", {std::string("world.frame_rate=") + rate, "world.duration=0.1"}));
    const auto& samples = world.tools[0].samples;
    ASSERT_GE(samples.size(), 98u) << rate;
    ASSERT_LE(samples.size(), 107u) << rate;
    for (std::size_t i = 0; i < samples.size(); i++)
      EXPECT_NEAR(samples[i].time, 1e-3 * double(i + 1), 1e-12);
  }
}

// The smooth surface of the pictures follows the tool: the dent is as deep as that of the surface with the
// patch.
TEST(TouchSfem, SmoothSurfaceFollowsPress) {
  const Exec exec(1);
  const Scene scene = body_scene(test::fresh_folder());
  World world = sfem_world(exec, scene);
  double deepest = 0;
  for (int frame = 0; frame < frame_count(scene); frame++) {
    ASSERT_TRUE(step(exec, world));
    BodySnapshot shown = shown_now(exec, world);
    show_smooth(shown);
    ASSERT_EQ(shown.smooth.triangles.size(), 16 * world.sfem_bodies[0].model.surface.triangles.size());
    double dent = 0, smooth_dent = 0;
    for (const Vec3 u : shown.displacement) dent = std::max(dent, double(norm(u)));
    for (const Vec3 u : shown.smooth.displacement) smooth_dent = std::max(smooth_dent, double(norm(u)));
    EXPECT_NEAR(smooth_dent, dent, 0.15 * dent + 1e-6) << "frame " << frame;
    deepest = std::max(deepest, dent);
    for (std::size_t v = 0; v < shown.smooth.x.size(); v += 97)
      EXPECT_NEAR(norm(shown.smooth.normals[v]), 1, 1e-4);
  }
  EXPECT_GT(deepest, 1e-3);
}

// The force starts at the surface, grows with depth and vanishes above it.
TEST(TouchSfem, ForceGrowsWithDepth) {
  const World world = run_world(Exec(1), body_scene(test::fresh_folder()));
  const auto& samples = world.tools[0].samples;
  double before = 0, largest = 0;
  for (const ForceSample& s : samples) {
    if (s.depth == 0) {
      EXPECT_LT(norm(s.force), 1e-3) << s.time;
    }
    if (s.time < 0.1) {
      EXPECT_GE(s.force.z, before - 1e-6) << s.time;
      before = s.force.z;
    }
    largest = std::max(largest, s.depth);
  }
  EXPECT_NEAR(largest, 0.003, 1e-4);
  // Hertz predicts 0.101 N for a ball of 6 mm pressed by 3 mm; the mesh is coarse, with a patch of 3.75 mm.
  EXPECT_NEAR(before, 0.1, 0.03);
  EXPECT_GT(world.sfem_bodies[0].rebuilds.size(), 1u) << "the patch follows";
}

// A new patch starts a fixed number of ticks after its request, and no tick is skipped.
TEST(TouchSfem, NewPatchStartsAfterFixedTicks) {
  World world = sfem_world(Exec(1), body_scene(test::fresh_folder()));
  SfemBody& body = world.sfem_bodies[0];
  touch_body(Exec(1), body, world.tools, 0, 0.1);  // pressed
  body.centers[0].x += 0.02;                       // far from the contact
  const std::size_t before = body.rebuilds.size(), ticks = world.tools[0].samples.size();
  touch_body(Exec(1), body, world.tools, 0.1, 0.11);
  ASSERT_EQ(body.rebuilds.size(), before + 1);
  EXPECT_NEAR(body.rebuilds.back().time, 0.101 + 1e-3 * kPatchTicks, 1e-9);
  const auto& samples = world.tools[0].samples;
  ASSERT_EQ(samples.size(), ticks + 10);
  for (std::size_t i = ticks; i < samples.size(); i++) {
    EXPECT_EQ(samples[i].new_patch, i == ticks + std::size_t(kPatchTicks));
    EXPECT_GT(norm(samples[i].force), 0.05) << "no tick is skipped";
  }
}

// The world has the same bits on 1, 2 and 8 threads.
TEST(TouchSfem, EqualBitsOnAnyThreads) {
  const auto folder = test::fresh_folder();
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 8})
    hashes.insert(state_hash(run_world(Exec(threads), body_scene(folder, "", {"body.pad.cache=false"}))));
  EXPECT_EQ(hashes.size(), 1u);
}

// Columns computed on demand yield the forces of the full matrix.
TEST(TouchSfem, ColumnsOnDemandMatchDense) {
  const auto folder = test::fresh_folder();
  const World dense = run_world(Exec(1), body_scene(folder, "", {"body.pad.cache=false"}));
  const World demand = run_world(Exec(1), body_scene(folder, "", {"body.pad.memory=0.004"}));
  ASSERT_TRUE(demand.sfem_bodies[0].facts.on_demand);
  EXPECT_NE(demand.sfem_bodies[0].facts.notes[0].find("their columns are computed on demand at the tools"),
            std::string::npos);
  const auto &a = dense.tools[0].samples, &b = demand.tools[0].samples;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); i++)
    EXPECT_NEAR(norm(a[i].force - b[i].force), 0, 1e-4 * largest_force(dense)) << a[i].time;
}

/// Force at the end of the press, when the tool has just stopped [N].
double pressed_force(const World& world) { return norm(world.tools[0].samples[99].force); }

// Viscous tissue resists a fast press and then relaxes.
TEST(TouchSfem, ViscousTissueRelaxes) {
  const auto folder = test::fresh_folder();
  const World elastic = run_world(Exec(1), body_scene(folder, "", {"world.duration=0.15"}));
  const World viscous = run_world(
      Exec(1), body_scene(folder, "viscosity = { ratio = 1, time = 0.05 }\n", {"world.duration=0.15"}));
  EXPECT_GT(pressed_force(viscous), 1.2 * pressed_force(elastic));
  EXPECT_LT(pressed_force(viscous), 2 * pressed_force(elastic));
  EXPECT_LT(norm(viscous.tools[0].samples.back().force), 0.9 * pressed_force(viscous));
  // The displayed surface lies on the patch: the coarse solution has the viscous history, too.
  const BodySnapshot surface = shown_now(Exec(1), viscous);
  double lowest = 0;
  for (const Vec3 u : surface.displacement) lowest = std::min(lowest, double(u.z));
  EXPECT_NEAR(lowest, -0.003, 3e-4);
}

// Corotation changes the force of a small press only slightly.
TEST(TouchSfem, RotationsChangeSmallPressLittle) {
  const auto folder = test::fresh_folder();
  const World plain = run_world(Exec(1), body_scene(folder, "", {"world.duration=0.15"}));
  const World turned = run_world(Exec(1), body_scene(folder, "rotations = true\n", {"world.duration=0.15"}));
  ASSERT_TRUE(turned.sfem_bodies[0].turning);
  EXPECT_EQ(turned.sfem_bodies[0].turning->frames, 9);
  EXPECT_NE(pressed_force(turned), pressed_force(plain));
  EXPECT_NEAR(pressed_force(turned), pressed_force(plain), 0.25 * pressed_force(plain));
}

// Held tissue is pulled with the tool until its release.
TEST(TouchSfem, HeldTissueIsPulled) {
  const auto folder = test::fresh_folder();
  std::string text = test::sfem_scene_text("cache = false\n");
  const std::size_t press = text.find("press = {"), end = text.find('\n', press);
  text.replace(
      press, end - press,
      "path = [[0, 0.03, 0.03, 0.037], [0.1, 0.03, 0.03, 0.034, 1], [0.3, 0.03, 0.03, 0.039, 1], [0.4, "
      "0.03, 0.03, 0.05, 0], [0.5, 0.03, 0.03, 0.05, 0]]");
  const Result<Scene> scene = parse_scene(text, folder / "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const World world = run_world(Exec(1), *scene);
  const auto& samples = world.tools[0].samples;
  EXPECT_GT(samples[99].force.z, 0.01) << "pressed";
  EXPECT_LT(samples[299].force.z, -0.01) << "pulled";
  EXPECT_LT(norm(samples.back().force), 1e-3) << "released";
}

// The displayed surface is closed and lies on the tool.
TEST(TouchSfem, SurfaceIsClosedAndLiesOnTool) {
  const Exec exec(1);
  const Scene scene = body_scene(test::fresh_folder(), "", {"world.duration=0.12"});
  const World world = run_world(exec, scene);
  const BodySnapshot surface = shown_now(exec, world);
  std::map<std::pair<int, int>, int> edges;
  for (const Int3 t : surface.triangles)
    for (int c = 0; c < 3; c++) edges[{t[c], t[(c + 1) % 3]}]++;
  int open = 0;
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    open += !edges.contains({edge.second, edge.first});
  }
  // At the border of the patch, a coarse edge meets its refined edges. Those do not match, all others do.
  EXPECT_LT(open, int(edges.size()) / 6);
  const contact::ToolPose& pose = world.sfem_bodies[0].now.poses[0];
  double nearest = 1;
  for (std::size_t v = 0; v < surface.rest.size(); v++)
    nearest = std::min(nearest, norm(Vec3d(surface.rest[v] + surface.displacement[v]) - pose.pose.position));
  EXPECT_NEAR(nearest, 0.006, 1e-4) << "no vertex is inside the ball, some touch it";
}

// A finer embedded surface follows the body and its patch.
TEST(TouchSfem, EmbeddedSurfaceFollows) {
  const auto folder = test::fresh_folder();
  // The pad's own top as two triangles per square of 2.5 mm.
  std::string obj;
  for (int j = 0; j <= 24; j++)
    for (int i = 0; i <= 24; i++)
      obj += "v " + std::to_string(2.5 * i) + " " + std::to_string(2.5 * j) + " 30\n";
  for (int j = 0; j < 24; j++)
    for (int i = 0; i < 24; i++) {
      const int a = j * 25 + i + 1;
      obj += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + 26) + " " +
             std::to_string(a + 25) + "\n";
    }
  test::write(folder / "top.obj", obj);
  const Exec exec(1);
  const World world = run_world(
      exec, body_scene(folder, "seen = \"top.obj\"\nseen_scale = 0.001\n", {"world.duration=0.12"}));
  const BodySnapshot surface = shown_now(exec, world);
  ASSERT_EQ(surface.rest.size(), 625u);
  const Vec3d ball = world.sfem_bodies[0].now.poses[0].pose.position;
  double lowest = 0, deepest_inside = 0;
  for (std::size_t v = 0; v < surface.rest.size(); v++) {
    const Vec3d x(surface.rest[v] + surface.displacement[v]);
    lowest = std::min(lowest, double(surface.displacement[v].z));
    deepest_inside = std::max(deepest_inside, 0.006 - norm(x - ball));
  }
  EXPECT_NEAR(lowest, -0.003, 5e-4) << "the dent is as deep as the press";
  EXPECT_LT(deepest_inside, 1e-3) << "the surface follows the patch around the ball";
}

/// Twelve frames with snapshots at the start, in the middle and at the end.
struct Recorded {
  WorldSnapshot snapshot;
  std::vector<Pressed> pressed;
};
void record(const Exec& exec, const std::filesystem::path& file, const Scene& scene, World& world,
            Recorded& recorded) {
  recorded.pressed = make_pressed(world);
  Result<RecordingWriter> writer = RecordingWriter::create(file, scene, world);
  ASSERT_TRUE(writer);
  for (int frame = 0; frame <= 12; frame++) {
    if (frame > 0) {
      ASSERT_TRUE(step(exec, world));
      update_pressed(exec, world, recorded.pressed);
    }
    if (frame % 6 != 0) continue;
    show(exec, world, recorded.snapshot);
    ASSERT_TRUE(writer->add_snapshot(world, recorded.snapshot));
  }
  ASSERT_TRUE(writer->finish(world, recorded.snapshot, recorded.pressed, "{}"));
}

// A recording restores surfaces and forces bit for bit.
TEST(TouchSfem, RecordingRestoresBits) {
  const auto folder = test::fresh_folder();
  const Exec exec(1);
  const Scene scene = body_scene(folder, "", {"world.duration=0.2"});
  World world = sfem_world(exec, scene);
  Recorded recorded;
  record(exec, folder / "r.h5", scene, world, recorded);
  const Result<Recording> recording = Recording::open(folder / "r.h5");
  ASSERT_TRUE(recording) << recording.error().message;
  const Result<Scene> again = recording->scene({});
  ASSERT_TRUE(again) << again.error().message;
  Result<World> drawn = load_world(exec, *again, {}, Purpose::kDraw);
  ASSERT_TRUE(drawn);
  WorldSnapshot snapshot;
  std::vector<Pressed> pressed;
  ASSERT_TRUE(recording->restore(exec, 2, *drawn, snapshot));
  ASSERT_TRUE(recording->restore_touch(*drawn, pressed));
  const BodySnapshot &a = recorded.snapshot.bodies[0], &b = snapshot.bodies[0];
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.rest, b.rest);
  EXPECT_EQ(a.displacement, b.displacement);
  EXPECT_EQ(a.pressure, b.pressure);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(recorded.snapshot.tools[0].pose.position, snapshot.tools[0].pose.position);
  EXPECT_EQ(recorded.snapshot.tools[0].mesh.vertices, snapshot.tools[0].mesh.vertices);
  EXPECT_EQ(recorded.pressed[0].body.displacement, pressed[0].body.displacement);
  EXPECT_EQ(recorded.pressed[0].force, pressed[0].force);
  ASSERT_EQ(world.tools[0].samples.size(), drawn->tools[0].samples.size());
  for (std::size_t i = 0; i < world.tools[0].samples.size(); i++) {
    EXPECT_EQ(world.tools[0].samples[i].force, drawn->tools[0].samples[i].force);
    EXPECT_EQ(world.tools[0].samples[i].depth, drawn->tools[0].samples[i].depth);
  }
}

// The table of forces has one column for every name.
TEST(TouchSfem, ForceTableHasColumnPerName) {
  const auto folder = test::fresh_folder();
  const World world = run_world(Exec(1), body_scene(folder, "", {"world.duration=0.05"}));
  ASSERT_TRUE(write_forces(folder / "f.csv", world.tools));
  const std::string text = read_file(folder / "f.csv").value();
  std::istringstream lines(text);
  std::size_t columns = 0, rows = 0;
  for (std::string line; std::getline(lines, line); rows++) {
    const auto count = std::size_t(std::count(line.begin(), line.end(), ','));
    columns = rows == 0 ? count : columns;
    EXPECT_EQ(count, columns) << line;
  }
  EXPECT_EQ(rows, 2 + world.tools[0].samples.size()) << "column names and the initial pose";
}

// A tool wider than the body presses it, with a warning. One that is ten times as wide is refused.
TEST(TouchSfem, ToolWiderThanBodyIsWarnedOf) {
  const auto folder = test::fresh_folder();
  World world = sfem_world(Exec(2), body_scene(folder, "", {"tool.finger.shape.sphere=0.05"}));
  for (int frame = 0; frame < 12; frame++) ASSERT_TRUE(step(Exec(2), world));
  EXPECT_GT(norm(world.tools[0].samples.back().force), 0.1) << "N";
  WorldSnapshot snapshot;
  show(Exec(2), world, snapshot);
  ASSERT_EQ(odd_sizes(snapshot).size(), 1u);
  EXPECT_NE(odd_sizes(snapshot)[0].find("finger: its contacting end has a size of "), std::string::npos);
  const Result<World> wide = load_world(Exec(1), body_scene(folder, "", {"tool.finger.shape.sphere=0.4"}));
  ASSERT_FALSE(wide);
  EXPECT_NE(wide.error().message.find("tool.finger: the tool is 0.8 m wide, the body pad 0.06 m"),
            std::string::npos)
      << wide.error().message;
}

// Nearly incompressible averaged tetrahedra yield a plausible force or an error, never a crash.
TEST(TouchSfem, NearlyIncompressibleNeverCrashes) {
  const auto folder = test::fresh_folder();
  const SolidMesh tets = tetrahedralize(hex_block({0.06, 0.06, 0.03}, {8, 8, 4}));
  ASSERT_TRUE(write_msh(folder / "pad.msh", tets));
  for (const char* poisson : {"0.499", "0.49995", "0.4999999", "0.49999999999"}) {
    std::string text = test::sfem_scene_text("formulation = \"averaged\"\ncache = false\n");
    const std::size_t block = text.find("block = {"), end = text.find('\n', block);
    text.replace(block, end - block, "mesh = \"pad.msh\"");
    text.replace(text.find("poisson = 0.4"), 13, std::string("poisson = ") + poisson);
    const Result<Scene> scene = parse_scene(text, folder / "s.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    Result<World> world = load_world(Exec(1), *scene);
    if (!world) {
      EXPECT_NE(world.error().message.find("lost to rounding"), std::string::npos) << world.error().message;
      continue;
    }
    touch_body(Exec(1), world->sfem_bodies[0], world->tools, 0, 0.1);
    const double force = norm(world->sfem_bodies[0].now.forces[0].force);
    EXPECT_TRUE(force > 0.05 && force < 1) << poisson << ": " << force;
  }
}

// A patch larger than the memory limit is refused before it is built, with advice.
TEST(TouchSfem, RejectsPatchBeyondMemory) {
  const auto folder = test::fresh_folder();
  const Result<World> world =
      load_world(Exec(1), body_scene(folder, "patch = { radius = 0.06, refinement = 4 }\nmemory = 0.3\n",
                                     {"body.pad.block.count=[12, 12, 6]"}));
  ASSERT_FALSE(world);
  for (const char* words :
       {"body.pad.patch: a patch of ", "nodes of its own and would take ", "allowed are 0.3 GB",
        "a smaller patch.radius, a lower patch.refinement or more memory"})
    EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message;
}

// If a patch cannot follow, the previous one remains in use and a warning is given.
TEST(TouchSfem, RejectedPatchKeepsPrevious) {
  World world = sfem_world(Exec(1), body_scene(test::fresh_folder()));
  SfemBody& body = world.sfem_bodies[0];
  touch_body(Exec(1), body, world.tools, 0, 0.1);
  const std::vector<int> elements = body.touch.patch->elements;
  body.patch_memory = 1000;
  body.centers[0].x += 0.02;  // far from the contact
  touch_body(Exec(1), body, world.tools, 0.1, 0.11);
  EXPECT_EQ(body.touch.patch->elements, elements);
  EXPECT_EQ(body.rejected_patches, 1) << "tried once, not in every tick";
  EXPECT_GT(norm(world.tools[0].samples.back().force), 0.05) << "the force continues";
  const std::vector<std::string> warnings = touch_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find(
                "pad: the patch did not follow the tools 1 times, the previous one stayed: a patch of "),
            std::string::npos)
      << warnings[0];
}

// The estimated memory of a patch is between the actual one and four times of it.
TEST(TouchSfem, PatchCostIsEstimated) {
  const World world = sfem_world(Exec(1), body_scene(test::fresh_folder()));
  const SfemBody& body = world.sfem_bodies[0];
  const sfem::PatchCost cost =
      sfem::patch_cost(body.model, body.touch.patch->elements, body.refinement, body.centers);
  EXPECT_EQ(cost.local_nodes, std::size_t(body.touch.patch->local_nodes));
  EXPECT_EQ(cost.points, body.touch.patch->points.size());
  double stored_bytes = double(body.touch.patch->compliance.size()) * 8;
  for (const sfem::PatchLevel& level : body.touch.patch->levels)
    stored_bytes += double(level.motion.size() + level.compliance.size()) * 8;
  const auto& system = std::get<0>(body.touch.patch->system);
  stored_bytes +=
      4 * double(system.factor.size() + system.coupling.size() + system.green.size() + system.change.size());
  EXPECT_GT(cost.bytes, stored_bytes);
  EXPECT_LT(cost.bytes, 4 * stored_bytes);
}

// The report has the forces in newtons and the times of all ticks.
TEST(TouchSfem, ReportHasForcesAndTimes) {
  const Exec exec(1);
  const Scene scene = body_scene(test::fresh_folder(), "", {"world.duration=0.2"});
  World world = sfem_world(exec, scene);
  Measures measures = make_measures(world);
  for (int frame = 1; frame <= frame_count(scene); frame++)
    measure_frame(exec, world, step(exec, world).value(), false, measures);
  const Json report = simulation_report(exec, scene, world, measures, {});
  EXPECT_EQ(report["bodies"][0]["mesh"]["vertices"], 9 * 9 * 5);
  EXPECT_EQ(report["tools"][0]["shape"], "sphere, radius 6 mm");
  // The maximum is over all ticks, not only over those that end a frame.
  EXPECT_GE(report["tools"][0]["force_max_N"].get<double>(), measures.pressed[0].force - 1e-6);
  const auto tick = std::size_t(std::floor(measures.pressed[0].time / kTick + 1e-9));
  ASSERT_TRUE(tick > 0 && tick <= world.tools[0].samples.size()) << tick;
  const Vec3d of_tick = world.tools[0].samples[tick - 1].force;
  ASSERT_EQ(measures.pressed[0].tools.size(), 1u);
  EXPECT_EQ(measures.pressed[0].tools[0].force, of_tick) << "bit by bit";
  // The compiler may fuse multiply and add in one copy of norm and not in another: up to 4 units in the last
  // digit apart.
  EXPECT_DOUBLE_EQ(measures.pressed[0].force, norm(of_tick));
  EXPECT_GE(report["tools"][0]["series"].size(), 190u);
  EXPECT_FALSE(report["scene"].contains("method"));
  EXPECT_EQ(report["state_hash"].get<std::string>().size(), 16u);
}

}  // namespace
}  // namespace turgor

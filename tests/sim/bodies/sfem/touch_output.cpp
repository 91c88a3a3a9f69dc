// Outputs of a press: displayed surfaces, recordings, the table of forces and the report.
#include <cmath>
#include <map>
#include <sstream>

#include "tests/sim/bodies/sfem/pressed_pad.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/recording/recording.hpp"
#include "turgor/sim/recording/recording_touch.hpp"
#include "turgor/sim/report/forces_csv.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/smooth_snapshot.hpp"

namespace turgor {
namespace {

using test::body_scene;
using test::run_world;
using test::sfem_world;
using test::shown_now;

// The smooth surface of the pictures follows the tool: the dent is as deep as that of the surface with the
// patch.
TEST(TouchOutput, SmoothSurfaceFollowsPress) {
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

// The displayed surface is closed and lies on the tool.
TEST(TouchOutput, SurfaceIsClosedAndLiesOnTool) {
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
TEST(TouchOutput, EmbeddedSurfaceFollows) {
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
TEST(TouchOutput, RecordingRestoresBits) {
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
TEST(TouchOutput, ForceTableHasColumnPerName) {
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

// The report has the forces in newtons and the times of all ticks.
TEST(TouchOutput, ReportHasForcesAndTimes) {
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

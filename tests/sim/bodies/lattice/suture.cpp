// Sutures of a scene: keys, errors, simulation, report, recording and state files.
#include "turgor/sim/bodies/lattice/suture.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/recorded_snapshot.hpp"
#include "tests/sim/resumed.hpp"
#include "tests/sim/scene/scene_error.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/report/report_skin.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

/// The block of block_scene.hpp with a suture of its cut.
std::string sutured_text(const std::string& keys) {
  return test::block_scene_text("block.nii") + "[suture.row]\nwound = \"cut\"\n" + keys;
}
Scene sutured_scene(const std::filesystem::path& folder, const std::string& keys, double duration,
                    std::vector<std::string> overrides = {}) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  overrides.push_back("world.duration=" + std::to_string(duration));
  Result<Scene> scene = parse_scene(sutured_text(keys), folder / "block.toml", overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

const char* const kRow = "bite = 0.012\ndepth = 0.004\nspacing = 0.015\nstart = 0.3\nduration = 0.3\n";

// A row of stitches closes the wound; the report states forces that balance and follow the thread's law.
TEST(Suture, RowClosesWound) {
  const Scene scene = sutured_scene(test::fresh_folder(), kRow, 1.6);
  World world = test::block_world(Exec(1), scene);
  const Result<Simulated> run = simulate(Exec(1), scene, world);
  ASSERT_TRUE(run) << run.error().message;
  const Json report = simulation_report(Exec(1), scene, world, run->measures, {});
  const Json& suture = report.at("sutures").at(0);
  EXPECT_EQ(suture.at("name"), "row");
  EXPECT_EQ(suture.at("wound"), "cut");
  EXPECT_EQ(suture.at("stitches_bearing"), 4);
  EXPECT_LT(suture.at("gape_max_mm").get<double>(), 0.3);
  EXPECT_GT(suture.at("closing_force_N").get<double>(), 0.5);
  EXPECT_GT(report.at("wounds").at(0).at("series").size(), 10u);
  const double stiffness = scene.sutures[0].thread.stiffness;
  double largest = 0;
  for (const lattice::Stitch& stitch : world.sutures[0].closure->stitches) {
    const double law = stiffness / stitch.length *
                       (loop_length(stitch, world.lattice_bodies[0].state->motion) - stitch.length);
    EXPECT_EQ(stitch.phase, lattice::StitchPhase::kKnotted);
    EXPECT_NEAR(stitch.tension, law, 0.01 * law) << "N";
    largest = std::max(largest, stitch.tension);
  }
  EXPECT_NEAR(suture.at("tension_max_N").get<double>(), largest, 1e-4 * largest);
  EXPECT_FALSE(run->snapshot.threads.at(0).triangles.empty());
  EXPECT_TRUE(suture_warnings(world).empty());
}

// The same wound in partial cells: stitches close it with nearly the same force, and come to rest.
TEST(Suture, RowClosesWoundInPartialCells) {
  double force[2];
  for (const int n : {0, 1}) {
    const Scene scene =
        sutured_scene(test::fresh_folder(), kRow, 1.6,
                      {std::string("body.block.tissue.partial_cells=") + (n ? "true" : "false")});
    ASSERT_EQ(scene.lattice_bodies[0].params.tissue.partial_cells, n == 1);
    World world = test::block_world(Exec(1), scene);
    const Result<Simulated> run = simulate(Exec(1), scene, world);
    ASSERT_TRUE(run) << run.error().message;
    const Json suture = simulation_report(Exec(1), scene, world, run->measures, {}).at("sutures").at(0);
    EXPECT_EQ(suture.at("stitches_bearing"), 4);
    EXPECT_LT(suture.at("gape_max_mm").get<double>(), 0.3);
    force[n] = suture.at("closing_force_N").get<double>();
  }
  std::printf("closing force %.3f N in whole cells, %.3f N in partial cells\n", force[0], force[1]);
  EXPECT_NEAR(force[1], force[0], 0.25 * force[0]) << "N";
}

// A single stitch closes the lips under it in partial cells, although its points lie below their skin, with
// nearly the force that it has in whole cells.
TEST(Suture, SingleStitchClosesLipsInPartialCells) {
  double gape[2], force[2];
  for (const int n : {0, 1}) {
    const Scene scene =
        sutured_scene(test::fresh_folder(),
                      "through = [[-0.010, -0.019, 0.004], [-0.010, -0.015, 0.004], [0.014, -0.015, 0.004], "
                      "[0.014, -0.019, 0.004]]\n",
                      1.6, {std::string("body.block.tissue.partial_cells=") + (n ? "true" : "false")});
    World world = test::block_world(Exec(1), scene);
    const Result<Simulated> run = simulate(Exec(1), scene, world);
    ASSERT_TRUE(run) << run.error().message;
    const Json suture = simulation_report(Exec(1), scene, world, run->measures, {}).at("sutures").at(0);
    EXPECT_EQ(suture.at("stitches_bearing"), 1);
    gape[n] = suture.at("gape_max_mm").get<double>(), force[n] = suture.at("closing_force_N").get<double>();
  }
  std::printf("gape %.3f mm and %.3f N in whole cells, %.3f mm and %.3f N in partial cells\n", gape[0],
              force[0], gape[1], force[1]);
  EXPECT_LT(gape[1], 0.3) << "mm";
  EXPECT_NEAR(force[1], force[0], 0.25 * force[0]) << "N";
}

// A running suture closes the wound with one thread, whose length is kept once it is closed.
TEST(Suture, RunningThreadClosesWound) {
  const Scene scene = sutured_scene(
      test::fresh_folder(), std::string(kRow) + "pattern = \"running\"\nthread_friction = 0.1\n", 1.6);
  World world = test::block_world(Exec(1), scene);
  const Result<Simulated> run = simulate(Exec(1), scene, world);
  ASSERT_TRUE(run) << run.error().message;
  const Json report = simulation_report(Exec(1), scene, world, run->measures, {});
  const Json& suture = report.at("sutures").at(0);
  EXPECT_EQ(suture.at("pattern"), "running");
  EXPECT_EQ(suture.at("stitches_bearing"), 4);
  EXPECT_LT(suture.at("gape_max_mm").get<double>(), 0.5);
  const std::vector<SutureSample>& series = run->measures.sutures.at(0).series;
  EXPECT_NEAR(series[series.size() - 10].thread_length, series.back().thread_length,
              1e-12 * series.back().thread_length);
  EXPECT_NEAR(suture.at("thread_length_mm").get<double>(), 1e3 * series.back().thread_length, 0.01);
  EXPECT_FALSE(run->snapshot.threads.at(0).triangles.empty());
}

// A body whose skin is stretched by a known factor has that factor in the map, and in the report its
// position.
TEST(Suture, StretchMapShowsFactor) {
  const Scene scene = sutured_scene(test::fresh_folder(), kRow, 0.8);
  World world = test::block_world(Exec(1), scene);
  LatticeBody& body = world.lattice_bodies[0];
  const Lattice& lattice = body.model.anatomy.lattice;
  lattice::Motion& motion = body.state.change().motion;
  const Vec3d along = normalized(Vec3d{1, 0, 2});
  for (const double factor : {1.15, 1.4}) {
    for (int slot = 0; slot < int(motion.u.x.size()); slot++) {
      const Vec3d x(rest_position(lattice, slot_node(lattice, slot)));
      motion.u.set(slot, Vec3(along * ((factor - 1) * dot(x, along))));
    }
    BodySnapshot snapshot;
    show_name({BodyKind::kLattice, 0}, body, snapshot);
    show(Exec(1), body, snapshot);
    const std::vector<float> map = skin_stretches(snapshot);
    ASSERT_EQ(map.size(), snapshot.x.size());
    // faces that contain the direction show it, others less
    const auto most = std::max_element(map.begin(), map.end());
    EXPECT_NEAR(double(*most), factor, 0.01 * factor);
    std::size_t front = 0;
    for (std::size_t v = 0; v < map.size(); v++) {
      if (snapshot.normals[v].y > Real(-0.999)) continue;  // beside a side face
      EXPECT_NEAR(double(map[v]), factor, 0.01 * factor) << "front, vertex " << v;
      front++;
    }
    EXPECT_GT(front, 50u);
  }
  const Json report = simulation_report(Exec(1), scene, world, make_measures(world), {});
  ASSERT_EQ(report.at("skin").size(), 1u);
  EXPECT_NEAR(report.at("skin").at(0).at("largest_stretch").get<double>(), 1.4, 0.014);
  EXPECT_TRUE(report.at("skin").at(0).at("in_ct").contains("x_mm"));
}

// Stitches that tear out are reported with a warning.
TEST(Suture, TornStitchesAreReported) {
  const Scene scene =
      sutured_scene(test::fresh_folder(), std::string(kRow) + "tension = 1.0\npull_out = 0.2\n", 0.8);
  World world = test::block_world(Exec(1), scene);
  const Result<Simulated> run = simulate(Exec(1), scene, world);
  ASSERT_TRUE(run) << run.error().message;
  const Json report = simulation_report(Exec(1), scene, world, run->measures, {});
  EXPECT_EQ(report.at("sutures").at(0).at("pulled_out"), 4);
  ASSERT_FALSE(suture_warnings(world).empty());
  EXPECT_NE(suture_warnings(world)[0].find("4 of 4 stitches tore out"), std::string::npos);
}

// A recording and a state file restore the stitches; a resumed world goes on with the same bits.
TEST(Suture, StateIsRestored) {
  const std::filesystem::path folder = test::fresh_folder();
  const Scene scene = sutured_scene(folder, kRow, 1);
  const Exec exec(1);
  World world = test::block_world(exec, scene), resumed = test::block_world(exec, scene);
  const LoadedPatches loaded = loaded_patches(world);
  for (int frame = 0; frame < 25; frame++) ASSERT_TRUE(step(exec, world));
  ASSERT_TRUE(world.sutures[0].closure);
  // recording
  const WorldSnapshot snapshot = test::record_snapshot(exec, folder / "r.h5", scene, world);
  World drawn = test::block_world(exec, scene);
  const WorldSnapshot redrawn = test::restore_snapshot(exec, folder / "r.h5", drawn);
  ASSERT_TRUE(drawn.sutures[0].closure);
  EXPECT_EQ(drawn.sutures[0].closure->stitches[1].tension, world.sutures[0].closure->stitches[1].tension);
  EXPECT_EQ(redrawn.threads.at(0).vertices, snapshot.threads.at(0).vertices);
  // state file
  test::expect_resumes(exec, folder / "state", loaded, world, resumed);
  EXPECT_EQ(resumed.sutures[0].closure->stitches[2].tension, world.sutures[0].closure->stitches[2].tension);
}

// The same of two sutures of one wound, after the first one has broken.
TEST(Suture, StateOfTwoSuturesIsRestored) {
  const std::filesystem::path folder = test::fresh_folder();
  const std::string second =
      "[suture.second]\nwound = \"cut\"\nthrough = [[-0.010, -0.019, 0.004], [-0.010, -0.015, 0.004], "
      "[0.014, "
      "-0.015, 0.004], [0.014, -0.019, 0.004]]\nstart = 0.3\n";
  const Scene scene = sutured_scene(folder, std::string(kRow) + "thread_strength = 0.05\n" + second, 1.5);
  const Exec exec(1);
  World world = test::block_world(exec, scene), resumed = test::block_world(exec, scene);
  const LoadedPatches loaded = loaded_patches(world);
  for (int frame = 0; frame < 50; frame++) ASSERT_TRUE(step(exec, world));
  ASSERT_FALSE(bears(*world.sutures[0].closure));
  ASSERT_TRUE(bears(*world.sutures[1].closure));
  const WorldSnapshot snapshot = test::record_snapshot(exec, folder / "r.h5", scene, world);
  World drawn = test::block_world(exec, scene);
  const WorldSnapshot redrawn = test::restore_snapshot(exec, folder / "r.h5", drawn);
  EXPECT_EQ(redrawn.threads.at(1).vertices, snapshot.threads.at(1).vertices);
  EXPECT_EQ(wall_force(*drawn.sutures[1].closure), wall_force(*world.sutures[1].closure));
  test::expect_resumes(exec, folder / "state", loaded, world, resumed);
  EXPECT_EQ(wall_force(*resumed.sutures[1].closure), wall_force(*world.sutures[1].closure));
}

// Wrong scenes are refused with the key and the reason.
TEST(Suture, WrongScenesAreRefused) {
  const auto error = [](const std::string& keys, const std::vector<std::string>& overrides = {}) {
    return test::error_of(sutured_text(keys), overrides);
  };
  const auto contains = [](const std::string& text, const std::string& sentence) {
    return text.find(sentence) != std::string::npos;
  };
  EXPECT_EQ(error(""), "no error");
  EXPECT_TRUE(contains(error("", {"suture.row.wound=cat"}), "no incision cat; did you mean cut?"));
  EXPECT_TRUE(contains(error("", {"body.block.solver.method=pbd"}), "stitches need solver.method = \"vbd\""));
  EXPECT_TRUE(
      contains(error("", {"incision.cut.width=0.01"}), "stitches close a cut, found a removed region"));
  EXPECT_TRUE(contains(error("start = 0.06\n"), "before the end of the cut at 0.1 s"));
  // 0.2 + 0.1 is rounded up
  EXPECT_EQ(
      error("start = 0.3\n", {"incision.cut.start=0.2", "incision.cut.duration=0.1", "world.duration=1"}),
      "no error");
  EXPECT_TRUE(contains(error("start = 9\n"), "after the end of the run"));
  EXPECT_TRUE(contains(error("tension = 1\npull_until = \"closed\"\n"), "not both"));
  EXPECT_TRUE(contains(error("through = [[0, 0, 0]]\n"), "two to 64 points"));
  EXPECT_TRUE(contains(error("thread = \"nylon 9-0\"\n"), "nylon 5-0"));
  EXPECT_TRUE(contains(error("pattern = \"running\"\ntension = 1\n"), "pulled until closed"));
  EXPECT_TRUE(
      contains(error("pattern = \"running\"\nthrough = [[0, 0, 0], [0.01, 0, 0]]\n"), "is not running"));
  EXPECT_TRUE(contains(error("pattern = \"walking\"\n"), "interrupted"));
}

// Stitches that do not fit the body are refused when it is loaded.
TEST(Suture, StitchesThatDoNotFitAreRefused) {
  const auto error = [](const std::string& keys) {
    const Scene scene = sutured_scene(test::fresh_folder(), keys, 1);
    const Result<World> world = load_world(Exec(1), scene);
    return world ? std::string("no error") : world.error().message;
  };
  EXPECT_NE(
      error("through = [[-0.01, -0.015, 0], [0.01, -0.04, 0]]\n").find("through air at [0.01, -0.04, 0] m"),
      std::string::npos);
  EXPECT_NE(error("thread_length = 0.02\n").find("the thread is shorter than its stitches"),
            std::string::npos);
  // beside the wound at x = 2 mm, across its line but far from it, and on both sides of it
  const auto through = [](double x, double z) {
    return fmt::format("through = [[{0}, -0.019, {2}], [{0}, -0.015, {2}], [{1}, -0.015, {2}]]\n", x - 0.01,
                       x + 0.01, z);
  };
  const std::string message = "through: expected points on both sides of the wound cut, found none near it";
  EXPECT_NE(error(through(0.03, 0)).find(message), std::string::npos) << error(through(0.03, 0));
  EXPECT_NE(error(through(0.002, 0.058)).find(message), std::string::npos) << error(through(0.002, 0.058));
  EXPECT_EQ(error(through(0.004, 0)), "no error");
}

// A suture of a wound whose body is missing is refused with the wound.
TEST(Suture, OfMissingBodyIsRefused) {
  const Result<Scene> scene = parse_scene(
      "[incision.cut]\nbody = \"torso\"\nfrom = [0, 0, 0]\nto = [0, 0, 0.1]\ndepth = 0.01\n"
      "[suture.row]\nwound = \"cut\"\nspacing = 0.01\nbite = 0.006\n",
      "s.toml", {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("torso"), std::string::npos) << scene.error().message;
}

}  // namespace
}  // namespace turgor

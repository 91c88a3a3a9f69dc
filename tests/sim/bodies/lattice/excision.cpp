// Excisions of a scene: keys, errors, simulation, report, recording and state files, closure by stitches.
#include <algorithm>
#include <cmath>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/recorded_snapshot.hpp"
#include "tests/sim/resumed.hpp"
#include "tests/sim/scene/scene_error.hpp"
#include "turgor/sim/deformed_ct.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

/// The block of block_scene.hpp, which loses a piece instead of being cut.
std::string excised_text(const std::string& keys = "length = 0.05\nwidth = 0.016\n",
                         const std::string& more = "") {
  const std::string text = test::block_scene_text("block.nii");
  const std::size_t cut = text.find("[incision.cut]"), output = text.find("[output]");
  return text.substr(0, cut) +
         "[excision.mole]\nbody = \"block\"\ncenter = [0.002, -0.02, 0.001]\ndirection = [0, 0, 1]\ndepth = "
         "0.01\nstart = 0.02\nduration = 0.04\n" +
         keys + more + text.substr(output);
}
Scene excised_scene(const std::filesystem::path& folder, const std::string& more, double duration,
                    const std::vector<std::string>& overrides = {}) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::vector<std::string> all = overrides;
  all.push_back("world.duration=" + std::to_string(duration));
  Result<Scene> scene =
      parse_scene(excised_text("length = 0.05\nwidth = 0.016\n", more), folder / "block.toml", all);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

/// Changes for the 8 mm lattice of the block.
const std::vector<std::string> kCoarse{"excision.mole.width=0.03", "excision.mole.depth=0.012"};
const char* const kStitches =
    "[suture.row]\nwound = \"mole\"\nbite = 0.008\ndepth = 0.003\nspacing = 0.01\nstart = 0.1\nduration = "
    "0.3\n";

/// Heights [mm] to which the drawn skin has risen toward −y beyond the ends of the lens, at z of -24 and 26
/// mm.
std::array<double, 2> drawn_heights(const World& world) {
  WorldSnapshot snapshot;
  show(Exec(1), world, snapshot);
  const BodySnapshot& body = snapshot.bodies[0];
  std::array<double, 2> heights{};
  for (std::size_t t = 0; t < body.wall_begin; t++)
    for (int k = 0; k < 3; k++) {
      const auto v = std::size_t(body.triangles[t][k]);
      const Vec3d rest(body.rest[v]), d(Vec3d(body.x[v]) - rest);
      for (const int end : {0, 1}) {
        const double along = (rest.z - 0.001) * (end ? 1 : -1) - 0.025, across = rest.x - 0.002;
        if (along < 0.001 || std::hypot(along, across) > 0.009 || rest.y > 0) continue;
        heights[std::size_t(end)] = std::max(heights[std::size_t(end)], -1e3 * d.y);
      }
    }
  return heights;
}

// The report states the piece and its wound; stitches close the wound.
TEST(Excision, ReportStatesPieceAndClosure) {
  const Scene scene = excised_scene(test::fresh_folder(), kStitches, 3.0, {"body.block.block=1"});
  World world = test::block_world(Exec(1), scene);
  const Result<Simulated> run = simulate(Exec(1), scene, world);
  ASSERT_TRUE(run) << run.error().message;
  const Json report = simulation_report(Exec(1), scene, world, run->measures, {});
  const Json& wound = report.at("wounds").at(0);
  EXPECT_EQ(wound.at("kind"), "excision");
  EXPECT_NEAR(wound.at("marked").at("length_mm").get<double>(), 50, 0.1);
  EXPECT_NEAR(wound.at("marked").at("width_mm").get<double>(), 16, 0.2);
  EXPECT_LT(wound.at("specimen").at("length_change_percent").get<double>(), -2);
  // fat of -100 HU
  EXPECT_NEAR(wound.at("specimen").at("mass_g").get<double>(),
              0.9 * wound.at("specimen").at("volume_ml").get<double>(), 1e-3);
  const auto [first, last] = drawn_heights(world);
  EXPECT_NEAR(wound.at("dog_ear").at("first_mm").get<double>(), first, 0.25 * first);
  EXPECT_NEAR(wound.at("dog_ear").at("last_mm").get<double>(), last, 0.25 * last);
  const Json& suture = report.at("sutures").at(0);
  EXPECT_EQ(suture.at("stitches_bearing"), 5);
  EXPECT_LT(suture.at("gape_max_mm").get<double>(), 0.15);
  EXPECT_GT(suture.at("closing_force_N").get<double>(), 0.5);
  EXPECT_LT(wound.at("opening_area_mm2").get<double>(),
            0.2 * wound.at("marked").at("area_mm2").get<double>());
  // a closed wound gapes less on average than where it gapes most
  EXPECT_LE(wound.at("gape_mean_mm").get<double>(), wound.at("gape_max_mm").get<double>());
  // stitches of a wide wound come to rest
  const std::vector<SutureSample>& series = run->measures.sutures.at(0).series;
  for (std::size_t n = series.size() - 25; n < series.size(); n++)
    EXPECT_NEAR(series[n].closing_force, series.back().closing_force, 2e-3 * series.back().closing_force)
        << "N at " << series[n].time;
}

// The deformed CT has air where the piece was, and tissue below its floor.
TEST(Excision, DeformedCtLacksThePiece) {
  const Scene scene = excised_scene(test::fresh_folder(), "", 0.2, kCoarse);
  const Exec exec(1);
  World world = test::block_world(exec, scene);
  const auto sample = [&](double y) {
    const DeformedCt found = make_deformed_ct(exec, world.lattice_bodies[0], world.frame, {}, 1000);
    const Grid& grid = found.ct.grid;
    const Vec3d at = Vec3d{0.002, y, 0.001} - grid.origin;
    return int(found.ct.at(int(std::lround(at.x / grid.spacing.x)), int(std::lround(at.y / grid.spacing.y)),
                           int(std::lround(at.z / grid.spacing.z))));
  };
  EXPECT_NEAR(sample(-0.014), -100, 30) << "HU";
  for (int frame = 0; frame < 6; frame++) ASSERT_TRUE(step(exec, world));
  ASSERT_TRUE(world.cuts[0].specimen);
  EXPECT_LT(sample(-0.014), -600) << "HU";
  EXPECT_NEAR(sample(0), -100, 30) << "HU";
}

// Specimen and wound do not depend on the number of threads.
TEST(Excision, SameBitsOnAnyThreads) {
  const Scene scene = excised_scene(test::fresh_folder(), "", 0.2, kCoarse);
  std::uint64_t hash[3];
  double length[3];
  const int threads[3] = {1, 2, 8};
  for (int n = 0; n < 3; n++) {
    World world = test::block_world(Exec(threads[n]), scene);
    for (int frame = 0; frame < 6; frame++) ASSERT_TRUE(step(Exec(threads[n]), world));
    ASSERT_TRUE(world.cuts[0].specimen);
    hash[n] = state_hash(world), length[n] = world.cuts[0].specimen->free.length;
  }
  EXPECT_EQ(hash[0], hash[1]);
  EXPECT_EQ(hash[0], hash[2]);
  EXPECT_EQ(length[0], length[1]);
  EXPECT_EQ(length[0], length[2]);
}

// A recording draws the body without its piece; a resumed world goes on with the same bits.
TEST(Excision, StateIsRestored) {
  const std::filesystem::path folder = test::fresh_folder();
  const Scene scene = excised_scene(folder, kStitches, 1, kCoarse);
  const Exec exec(1);
  World world = test::block_world(exec, scene), resumed = test::block_world(exec, scene);
  const LoadedPatches loaded = loaded_patches(world);
  for (int frame = 0; frame < 8; frame++) ASSERT_TRUE(step(exec, world));
  ASSERT_TRUE(world.cuts[0].specimen && world.sutures[0].closure);
  // recording
  const WorldSnapshot snapshot = test::record_snapshot(exec, folder / "r.h5", scene, world);
  World drawn = test::block_world(exec, scene);
  const WorldSnapshot redrawn = test::restore_snapshot(exec, folder / "r.h5", drawn);
  EXPECT_EQ(redrawn.bodies[0].triangles, snapshot.bodies[0].triangles);
  EXPECT_EQ(redrawn.bodies[0].x, snapshot.bodies[0].x);
  EXPECT_EQ(redrawn.threads.at(0).vertices, snapshot.threads.at(0).vertices);
  // state file
  test::expect_resumes(exec, folder / "state", loaded, world, resumed);
  EXPECT_EQ(resumed.cuts[0].specimen->free.length, world.cuts[0].specimen->free.length);
}

// Wrong keys are refused with the key and the reason.
TEST(Excision, WrongKeysAreRefused) {
  const auto error = [](const std::string& keys, const std::vector<std::string>& overrides = {}) {
    return test::error_of(excised_text(keys), overrides);
  };
  const auto expect = [](const std::string& text, const std::string& sentence) {
    EXPECT_NE(text.find(sentence), std::string::npos) << text;
  };
  EXPECT_EQ(error("length = 0.05\nwidth = 0.016\n"), "no error");
  expect(error("length = 0.03\nwidth = 0.05\n"), "the piece is wider than long");
  expect(error("width = 0.03\n"), "length");
  expect(error("length = 0.05\nwidth = 0.016\ncenter_fraction = [0, 0, 0]\n"), "is given once");
  expect(error("length = 0.05\nwidth = 0.016\n", {"excision.mole.start=9"}), "after the end of the run");
  expect(error("length = 0.05\nwidth = 0.016\n", {"excision.mole.direction=[0, 0, 0]"}),
         "vector without length");
  expect(error("length = 0.05\nwidth = 0.016\n", {"body.block.solver.method=pbd"}),
         "solver.method = \"vbd\"");
  expect(error("length = 0.05\nwidth = 0.016\n", {"excision.wart.width=0.01"}), "no excision wart");
}

// Pieces that do not fit the body are refused when it is loaded.
TEST(Excision, PiecesThatDoNotFitAreRefused) {
  const std::filesystem::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const auto expect = [&](const std::vector<std::string>& overrides, const std::string& sentence,
                          const std::string& more = "") {
    const Result<Scene> scene =
        parse_scene(excised_text("length = 0.05\nwidth = 0.016\n", more), folder / "block.toml", overrides);
    ASSERT_TRUE(scene) << scene.error().message;
    const Result<World> world = load_world(Exec(1), *scene);
    ASSERT_FALSE(world) << sentence;
    EXPECT_NE(world.error().message.find("excision.mole: "), std::string::npos) << world.error().message;
    EXPECT_NE(world.error().message.find(sentence), std::string::npos) << world.error().message;
  };
  expect({"excision.mole.center=[0.002, -0.2, 0.001]"}, "no skin within 0.1 m");
  expect({"excision.mole.depth=0.05"}, "expected a smaller depth");
  expect({"excision.mole.direction=[0, 1, 0]"}, "normal to the skin");
  const Result<Scene> scene = parse_scene(
      excised_text(
          "length = 0.05\nwidth = 0.016\n",
          "[excision.near]\nbody = \"block\"\ncenter = [0.012, -0.02, 0.01]\nlength = 0.02\nwidth = 0.02\n"),
      folder / "block.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<World> world = load_world(Exec(1), *scene);
  ASSERT_FALSE(world);
  EXPECT_NE(world.error().message.find("overlaps excision 'mole'"), std::string::npos)
      << world.error().message;
}

}  // namespace
}  // namespace turgor

// Skin tension that changes after cuts: the prestress at the wound follows it.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/report/measures.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::step_frames;

const Exec kSole(1);

/// A limb: fat around bone along z, with a radius of 60 mm. Its curved skin presses on the fat.
CtVolume limb_ct() {
  CtVolume ct;
  ct.grid.size = {40, 40, 30}, ct.grid.spacing = {0.004, 0.004, 0.004};
  ct.grid.origin = {-0.078, -0.078, -0.058};
  ct.samples.assign(sample_count(ct.grid), kAirHu);
  for (int k = 0; k < 30; k++)
    for (int j = 0; j < 40; j++)
      for (int i = 0; i < 40; i++) {
        const double radius = std::hypot(i - 19.5, j - 19.5) * 0.004;
        if (radius < 0.06) ct.at(i, j, k) = radius < 0.025 ? 1000 : -100;
      }
  return ct;
}

/// The limb with a cut along it in front.
std::shared_ptr<const Scene> limb_scene(const fs::path& folder, double tension, bool partial) {
  EXPECT_TRUE(write_ct(folder / "limb.nii", limb_ct()));
  const std::string text =
      "[world]\nframe_rate = 50\n[body.limb]\nmodel = \"lattice\"\nct = \"limb.nii\"\nblock = 2\n"
      "fixed = [\"bone\", \"ends\"]\n[incision.cut]\nbody = \"limb\"\nfrom = [0.002, -0.06, -0.03]\n"
      "to = [0.002, -0.06, 0.03]\ndepth = 0.014\n";
  Result<Scene> scene = parse_scene(text, folder / "limb.toml",
                                    {fmt::format("body.limb.skin.tension={}", tension),
                                     fmt::format("body.limb.tissue.partial_cells={}", partial)});
  EXPECT_TRUE(scene) << scene.error().message;
  return std::make_shared<const Scene>(std::move(*scene));
}
void change_tension(std::shared_ptr<const Scene>& scene, World& world, double tension) {
  const ChangeRequest change{"body.limb.skin.tension", fmt::format("{}", tension)};
  ASSERT_TRUE(apply_request(kSole, change, scene, world));
}

void expect_same_prestress(const World& a, const World& b) {
  const lattice::CutElements &found = a.lattice_bodies.at(0).state.cut_elements(),
                             &expected = b.lattice_bodies.at(0).state.cut_elements();
  ASSERT_EQ(found.nodes.size(), expected.nodes.size());
  ASSERT_EQ(found.virtual_nodes.size(), expected.virtual_nodes.size());
  double largest = 0;
  for (std::size_t n = 0; n < found.virtual_nodes.size(); n++) {
    largest = std::max(largest, double(norm(found.virtual_nodes[n].prestress_force)));
    EXPECT_EQ(found.virtual_nodes[n].prestress_force, expected.virtual_nodes[n].prestress_force) << n;
  }
  for (std::size_t n = 0; n < found.nodes.size(); n++)
    EXPECT_EQ(found.nodes[n].prestress_force, expected.nodes[n].prestress_force) << n;
  EXPECT_GT(largest, 1e-3) << "N: the skin is curved";
}

const CutRequest kSecondCut{
    .blade = {.name = "b", .from = {0.03, -0.055, -0.03}, .to = {0.03, -0.055, 0.03}, .depth = 0.012},
    .body = 0};

// Nodes at a wound have the prestress of the present tension, exactly as with this tension from the start.
TEST(ChangeTension, WoundHasPresentPrestress) {
  const fs::path folder = test::fresh_folder();
  for (const bool partial : {false, true}) {
    auto scene = limb_scene(folder, 45, partial);
    World changed = test::block_world(kSole, *scene),
          tense = test::block_world(kSole, *limb_scene(folder, 90, partial));
    step_frames(changed, 1), step_frames(tense, 1);
    change_tension(scene, changed, 90);
    expect_same_prestress(changed, tense);
  }
}

// So do they after a later cut is taken back that was made under another tension.
TEST(ChangeTension, UndoneCutLeavesPresentPrestress) {
  const fs::path folder = test::fresh_folder();
  auto scene = limb_scene(folder, 45, false);
  World changed = test::block_world(kSole, *scene),
        tense = test::block_world(kSole, *limb_scene(folder, 90, false));
  step_frames(changed, 2), step_frames(tense, 1);
  ASSERT_TRUE(apply_request(kSole, kSecondCut, scene, changed));
  step_frames(changed, 2);
  const std::size_t nodes = changed.lattice_bodies[0].state.cut_elements().nodes.size();
  change_tension(scene, changed, 90);
  ASSERT_TRUE(apply_request(kSole, UndoCutRequest{}, scene, changed));
  EXPECT_LT(changed.lattice_bodies[0].state.cut_elements().nodes.size(), nodes);
  expect_same_prestress(changed, tense);
}

// Elements of an earlier cut have the moduli of the present tissue after a later cut is taken back.
TEST(ChangeTension, UndoneCutLeavesPresentModuli) {
  const fs::path folder = test::fresh_folder();
  auto scene = limb_scene(folder, 45, false);
  World changed = test::block_world(kSole, *scene);
  step_frames(changed, 2);
  ASSERT_TRUE(apply_request(kSole, kSecondCut, scene, changed));
  step_frames(changed, 2);
  for (const auto& [key, value] :
       {std::pair("body.limb.tissue.fat", "8000"), {"body.limb.stiffness_scale", "3"}})
    ASSERT_TRUE(apply_request(kSole, ChangeRequest{key, value}, scene, changed));
  ASSERT_TRUE(apply_request(kSole, UndoCutRequest{}, scene, changed));
  World loaded = test::block_world(kSole, *scene);
  step_frames(loaded, 1);
  const auto &found = changed.lattice_bodies.at(0).state.cut_elements().cells,
             &expected = loaded.lattice_bodies.at(0).state.cut_elements().cells;
  ASSERT_EQ(found.size(), expected.size());
  EXPECT_GT(found.size(), 20u);
  for (std::size_t n = 0; n < found.size(); n++)
    EXPECT_NEAR(found[n].young, expected[n].young, 1e-5 * double(expected[n].young)) << n;
}

/// Largest displacement and gape after frames in which the body settles.
struct Settled {
  lattice::VecField u;
  double gape = 0;  // [m]
};
Settled settled(World& world) {
  Measures measures = make_measures(world);
  step_frames(world, 100);
  measure_frame(kSole, world, FrameReport{}, false, measures);
  return {world.lattice_bodies.at(0).state.host().motion.u, measures.cuts.at(0).wound.gape_max};
}

// A cut limb whose tension doubles settles in the shape that it has with this tension from the start.
TEST(ChangeTension, SettlesAsWithTensionFromStart) {
  const fs::path folder = test::fresh_folder();
  auto scene = limb_scene(folder, 45, false);
  World changed = test::block_world(kSole, *scene),
        tense = test::block_world(kSole, *limb_scene(folder, 90, false));
  const Settled before = settled(changed), expected = settled(tense);
  change_tension(scene, changed, 90);
  const Settled found = settled(changed);
  double effect = 0, difference = 0;
  for (int n = 0; n < int(expected.u.x.size()); n++) {
    effect = std::max(effect, double(norm(before.u[n] - expected.u[n])));
    difference = std::max(difference, double(norm(found.u[n] - expected.u[n])));
  }
  EXPECT_GT(effect, 1e-3) << "m";
  EXPECT_LT(difference, 0.02 * effect) << "m";
  EXPECT_NEAR(found.gape, expected.gape, 0.002 * expected.gape) << "m";
}

}  // namespace
}  // namespace turgor

// Dents of viscous and plastic tissue: that of scenes/creep.toml, and those of two jaws. They return in part.
#include <algorithm>
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/block_scene.hpp"
#include "turgor/models/lattice/solver/viscosity.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

/// Largest displacement of a body [m].
double dent_depth(const World& world) {
  const lattice::Motion& motion = world.lattice_bodies[0].state->motion;
  double most = 0;
  for (std::size_t slot = 0; slot < motion.u.x.size(); slot++)
    most = std::max(most, norm(Vec3d(motion.u[slot])));
  return most;
}

struct Dent {
  double pressed, early, late;  // below the ball; soon after it left, and a third of a second later [m]
  double set;                   // largest permanent strain of the body [1]
  Json reported;
};

/// The scene with cells of 14 mm and a shorter press.
Dent dent_of(const std::vector<std::string>& more) {
  std::vector<std::string> overrides{"body.thigh.spacing=0.014", "world.duration=1.2", "world.frame_rate=50",
                                     "tool.ball.press.hold=0.2"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  const Exec exec(2);
  const std::filesystem::path file = TURGOR_SOURCE_DIR "/scenes/creep.toml";
  const Result<Scene> scene = read_scene(file, overrides);
  EXPECT_TRUE(scene) << scene.error().message;
  World world = test::block_world(exec, *scene);
  Dent dent{};
  RunEvents events;
  events.frame = [&dent](const World& now) {
    dent.pressed = std::max(dent.pressed, dent_depth(now));
    if (now.frame == 43) dent.early = dent_depth(now);
    return true;
  };
  const Result<Simulated> done = simulate(exec, *scene, world, events);
  EXPECT_TRUE(done);
  dent.late = dent_depth(world);
  const LatticeBody& body = world.lattice_bodies[0];
  if (lattice::has_set(body.model.params.tissue.set))
    dent.set = lattice::largest_set(exec, body.model, *body.state);
  const Json report = simulation_report(exec, *scene, world, done->measures, {});
  dent.reported = bodies_of(report, BodyKind::kLattice)[0];
  return dent;
}

// The dent gets flatter after the ball left. A part stays, which the report states; without `permanent_set`,
// less stays and the report states none.
TEST(Creep, DentComesBackInPart) {
  const Dent plastic = dent_of({}), viscous = dent_of({"body.thigh.permanent_set.share=0"});
  for (const Dent& dent : {plastic, viscous}) {
    EXPECT_GT(dent.early, 0.002);
    EXPECT_LT(dent.early, 0.5 * dent.pressed) << "the ball has left";
    EXPECT_LT(dent.late, 0.9 * dent.early);
  }
  EXPECT_GT(plastic.late, 1.2 * viscous.late);
  EXPECT_GT(plastic.set, 0.02);
  EXPECT_NEAR(double(plastic.reported["set_max_percent"]), 100 * plastic.set, 0.001 * plastic.set);
  EXPECT_FALSE(viscous.reported.contains("set_max_percent"));
  std::printf("%.2f %.3f %.3f mm; %.2f %.3f %.3f mm\n", 1e3 * plastic.pressed, 1e3 * plastic.early,
              1e3 * plastic.late, 1e3 * viscous.pressed, 1e3 * viscous.early, 1e3 * viscous.late);
}

/// Dents at both ends of a block of fat after two jaws have squeezed it by 12 mm each and opened, and the
/// permanent strain of the report.
struct JawDents {
  double squeezed, left, right;  // [m]
  double set_percent;            // 0: not reported
};
JawDents squeeze_between_jaws(const std::string& body) {
  const std::filesystem::path folder = test::fresh_folder();
  const Exec exec(2);
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::string text =
      "[world]\nduration = 1.5\nframe_rate = 50\ngravity = [0, 0, 0]\n[body.block]\nmodel = \"lattice\"\n"
      "ct = \"block.nii\"\nblock = 2\nfixed = \"bone\"\nskin = false\nsolver = { sweeps = 10, damping = 4 "
      "}\n" +
      body;
  for (const auto& [name, side] : {std::pair("left", "0"), std::pair("right", "1")})
    text += std::string("[tool.") + name +
            "]\nbody = \"block\"\nshape = { sphere = 0.016 }\npress = { at_fraction = [" + side +
            ", 0.25, 0.5], depth = 0.012, start = 0, duration = 0.2, hold = 0.3 }\n";
  const Scene scene = parse_scene(text, folder / "jaws.toml", {}).value();
  World world = test::block_world(exec, scene);
  JawDents dents{};
  RunEvents events;
  events.frame = [&dents](const World& now) {
    dents.squeezed = std::max(dents.squeezed, dent_depth(now));
    return true;
  };
  const Result<Simulated> done = simulate(exec, scene, world, events);
  EXPECT_TRUE(done);
  const lattice::Motion& motion = world.lattice_bodies[0].state->motion;
  for (std::size_t slot = 0; slot < motion.u.x.size(); slot++) {
    const double inward = double(motion.u.x[slot]);
    dents.left = std::max(dents.left, inward), dents.right = std::max(dents.right, -inward);
  }
  const Json report =
      bodies_of(simulation_report(exec, scene, world, done->measures, {}), BodyKind::kLattice)[0];
  dents.set_percent = report.value("set_max_percent", 0.0);
  return dents;
}

// Tissue that two jaws grasp keeps a dent on both sides after they open, which the report states; elastic
// tissue keeps none. (Forceps do not open on a lattice, so that two tools are the jaws.)
TEST(Creep, JawsLeaveDents) {
  const JawDents plastic =
                     squeeze_between_jaws("permanent_set = { share = 0.6, strain = 0.05, time = 0.1 }\n"),
                 elastic = squeeze_between_jaws("tissue = { partial_cells = false }\n");
  EXPECT_GT(elastic.squeezed, 0.009);
  EXPECT_GT(plastic.squeezed, 0.009);
  for (const double dent : {elastic.left, elastic.right}) EXPECT_LT(dent, 0.05 * elastic.squeezed);
  for (const double dent : {plastic.left, plastic.right}) EXPECT_GT(dent, 0.15 * plastic.squeezed);
  EXPECT_GT(plastic.set_percent, 5);
  EXPECT_EQ(elastic.set_percent, 0);
  std::printf("plastic %.2f: %.2f %.2f mm, set %.1f %%; elastic %.2f: %.3f %.3f mm\n", 1e3 * plastic.squeezed,
              1e3 * plastic.left, 1e3 * plastic.right, plastic.set_percent, 1e3 * elastic.squeezed,
              1e3 * elastic.left, 1e3 * elastic.right);
}

}  // namespace
}  // namespace turgor

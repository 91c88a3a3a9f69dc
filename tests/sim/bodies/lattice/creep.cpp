// The dent of scenes/creep.toml: it returns in part.
#include <algorithm>
#include <cstdio>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace turgor

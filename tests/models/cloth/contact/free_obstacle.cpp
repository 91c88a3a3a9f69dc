#include "turgor/models/cloth/contact/free_obstacle.hpp"

#include <gtest/gtest.h>

#include "tests/models/cloth/sheets.hpp"
#include "turgor/geometry/ball_mesh.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/cloth/hold.hpp"

namespace turgor::cloth {
namespace {

constexpr double kMass = 0.2, kRadius = 0.03;

/// A sheet whose rim is held, below a ball that falls on it beside its middle.
struct BallOnSheet {
  Model model;
  State state;
  Inputs inputs = in_vacuum();
  Vec3d center{0.093, 0.1, kRadius + 0.0015};

  explicit BallOnSheet(double speed) {
    Params params;
    params.solver.method = Method::kTwoLevel;
    model = must_build(flat_sheet(21), params);
    state = make_state(model);
    for (int v = 0; v < 441; v++)
      if (v % 21 == 0 || v % 21 == 20 || v < 21 || v >= 420) (void)hold(model, state, v);
    TriMesh ball = ball_mesh(kRadius, 3);
    for (Vec3& x : ball.vertices) x += Vec3(center);
    std::vector<Vec3> after = ball.vertices;
    for (Vec3& x : after) x.z -= Real(speed * kFrame);
    inputs.obstacles = {surface_obstacle(moving_surface(ball, after, kFrame))};
    inputs.obstacles[0].friction = 0.5, inputs.obstacles[0].gap = 0.001;
    inputs.obstacles[0].speed = speed;
  }
  /// The cloth moves the ball, whose velocity includes a load already.
  void set_free(double mass, Vec3d force = {}) {
    const double moment = 0.4 * mass * kRadius * kRadius;
    inputs.obstacles[0].free = FreeInertia{.center = center,
                                           .mass = mass,
                                           .inertia = {{{moment, 0, 0}, {0, moment, 0}, {0, 0, moment}}},
                                           .force = force,
                                           .torque = {},
                                           .frame = kFrame};
  }
  void run() { EXPECT_TRUE(step(Exec(1), model, state, inputs, kFrame).finite); }
};

// The body changes its momentum by the impulse of the contacts beyond the load that it had. Friction, and
// tension of contacts that open, are solved to 1 % each.
TEST(FreeObstacle, MomentumIsThatOfImpulses) {
  for (const double force : {0.0, 1.0}) {
    BallOnSheet scene(0.5);
    scene.set_free(kMass, {0, 0, force});
    scene.run();
    ASSERT_EQ(scene.state.implicit_contacts.free.size(), 1u);
    const FreeObstacle& free = scene.state.implicit_contacts.free[0];
    const ObstacleLoad load = free_obstacle_load(scene.state, 0);
    const Vec3d gained = free.velocity * kMass, expected = load.impulse - Vec3d{0, 0, force * kFrame};
    EXPECT_GT(load.impulse.z, 0) << "N s, of the sheet on the ball";
    EXPECT_LT(norm(gained - expected), 0.02 * norm(load.impulse));
    const Vec3d turned = free.spin * (0.4 * kMass * kRadius * kRadius);
    EXPECT_LT(norm(turned - load.moment), 0.02 * kRadius * norm(load.impulse));
  }
}

// A body of infinite mass moves as one whose motion is given.
TEST(FreeObstacle, HeavyBodyKeepsItsMotion) {
  BallOnSheet heavy(0.5), given(0.5);
  heavy.set_free(1e9);
  heavy.run(), given.run();
  for (std::size_t v = 0; v < std::size_t(given.model.count); v++)
    ASSERT_LT(norm(heavy.state.x[v] - given.state.x[v]), Real(1e-6)) << v;
  EXPECT_LT(norm(heavy.state.implicit_contacts.free[0].velocity), 1e-6);
}

// Sheet and body meet at one velocity: no vertex of the sheet is nearer than the gap after the step.
TEST(FreeObstacle, ContactsEndAtTheGap) {
  BallOnSheet scene(0.5);
  scene.set_free(kMass);
  scene.run();
  const FreeObstacle& free = scene.state.implicit_contacts.free[0];
  const Vec3d center = scene.center + (Vec3d{0, 0, -0.5} + free.velocity) * kFrame;
  EXPECT_GT(free.velocity.z, 0) << "m/s";
  for (std::size_t v = 0; v < std::size_t(scene.model.count); v++)
    EXPECT_GT(norm(Vec3d(scene.state.x[v]) - center), kRadius + 0.001 - 2e-4) << v;
}

}  // namespace
}  // namespace turgor::cloth

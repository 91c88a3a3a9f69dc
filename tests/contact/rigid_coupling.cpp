// Rigid bodies in the coupling of bodies, and sites of round shapes.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turgor/contact/pair_sites.hpp"
#include "turgor/geometry/ball_mesh.hpp"
#include "turgor/models/rigid/rigid.hpp"

namespace turgor {
namespace {

using contact::PairSite;
using contact::PairSurface;
using contact::RigidLoad;
using contact::RigidMotion;
using contact::Tie;

constexpr double kStep = 1.0 / 60;

/// A tilted box that spins.
struct Spinning {
  rigid::Model model;
  rigid::State state;
};
Spinning spinning() {
  Spinning made;
  made.model.mass = {.mass = 0.3,
                     .center = {0.1, 0.02, -0.05},
                     .axes = axes_of(rigid::rotation_of({0.3, 0.2, -0.7})),
                     .moments = {3e-5, 7e-5, 8e-5}};
  made.state = rigid::make_state(made.model, {0.2, -0.1, 0.3}, {3, -5, 2});
  made.state.rotation = rigid::rotation_of({0.9, -1.2, 2.1});
  return made;
}
rigid::State after(const Spinning& body, const RigidLoad& load) {
  return rigid::moved(body.model, body.state, load.force * kStep, load.torque * kStep, kStep);
}
Pose center_of(const rigid::State& state) { return {state.center, axes_of(state.rotation)}; }
RigidMotion motion_of(const Spinning& body) {
  RigidMotion motion{.rest_center = body.model.mass.center,
                     .before = center_of(body.state),
                     .after = {},
                     .shift = {},
                     .turn = {}};
  motion.translation = kStep * kStep / body.model.mass.mass;
  motion.rotation = rigid::inverse_inertia(body.model, body.state.rotation);
  for (Vec3d& column : motion.rotation.column) column *= kStep * kStep;
  contact::linearize(center_of(after(body, {})), {}, motion);
  return motion;
}

// A stiff tie holds a point of a spinning body in space: after some linearizations the point is where the tie
// has it, also by the nonlinear motion.
TEST(RigidCoupling, StiffTie_HoldsPointExactly) {
  const Spinning body = spinning();
  const Vec3d held = body.model.mass.center + Vec3d{0.02, -0.01, 0.03};
  const Vec3d now = to_world(center_of(body.state), held - body.model.mass.center);
  std::vector<contact::CoupledBody> bodies(1);
  bodies[0].rigid = motion_of(body);
  // its position now is kept: the other point's position at rest is that of the point, displaced to the
  // present one
  std::vector<Tie> ties{{.a = {0, {-1, -1, -1}, {}, held},
                         .b = {.body = -1, .weight = {}, .rest = held},
                         .stiffness = 1e7,
                         .force = {}}};
  double error = 0;
  for (int n = 0; n < 6; n++) {
    contact::solve_coupling(Exec(1), bodies, ties, {});
    const RigidLoad load = contact::load_on(0, *bodies[0].rigid, ties, {});
    const Pose pose = center_of(after(body, load));
    error = contact::linearization_error(0, *bodies[0].rigid, pose, load, ties, {});
    contact::linearize(pose, load, *bodies[0].rigid);
  }
  const Vec3d found = to_world(bodies[0].rigid->after, held - body.model.mass.center);
  std::printf("moved by %.3g m, error %.2g m\n", norm(now - held), error);
  EXPECT_LT(error, 1e-6 * norm(now - held));
  EXPECT_LT(norm(found - held + ties[0].force / 1e7), 1e-5 * norm(now - held));
}

// A support with inertia yields to forces as a rigid body with this mass and inertia does, and starts from
// its free displacement.
TEST(RigidCoupling, SupportWithInertia_YieldsAsRigidBody) {
  Spinning body = spinning();
  const Vec3d velocity{0.06, -0.12, 0.03};
  body.state = rigid::make_state(body.model, velocity);
  const RigidMotion motion = motion_of(body);
  // two ties that also turn the body
  const Vec3d points[] = {{0.12, 0.03, -0.05}, {0.1, 0.02, -0.02}}, ahead = velocity * kStep;
  std::vector<Tie> ties;
  for (int n = 0; n < 2; n++)
    ties.push_back({.a = {0, {n, -1, -1}, {1, 0, 0}, points[n]},
                    .b = {.body = -1, .weight = {}, .rest = points[n]},
                    .stiffness = 400,
                    .force = {}});
  std::vector<Tie> of_support = ties;
  std::vector<contact::CoupledBody> rigid(1), support(1);
  rigid[0].rigid = motion;
  support[0].free.assign(2, ahead), support[0].is_support = true;
  support[0].inertia = {motion.rest_center + ahead, motion.translation, motion.rotation};
  contact::solve_coupling(Exec(1), rigid, ties, {});
  contact::solve_coupling(Exec(1), support, of_support, {});
  for (std::size_t n = 0; n < 2; n++)
    EXPECT_LT(norm(of_support[n].force - ties[n].force), 1e-9 * norm(ties[0].force));
  EXPECT_GT(norm(ties[0].force), 0);
}

// A box of this size around the origin, as a surface at a position.
struct Placed {
  std::vector<Vec3d> rest, x;
  std::vector<Int3> triangles;
};
Placed grid_plate(double half, int cells) {
  Placed plate;
  for (int j = 0; j <= cells; j++)
    for (int i = 0; i <= cells; i++)
      plate.rest.push_back({half * (2.0 * i / cells - 1), half * (2.0 * j / cells - 1), 0});
  for (int j = 0; j < cells; j++)
    for (int i = 0; i < cells; i++) {
      const int v = j * (cells + 1) + i;
      plate.triangles.push_back({v, v + 1, v + cells + 2}),
          plate.triangles.push_back({v, v + cells + 2, v + cells + 1});
    }
  plate.x = plate.rest;
  return plate;
}

/// A ball or a capsule at a pose, as a surface.
PairSurface round_surface(int body, double radius, const std::array<Vec3d, 2>& ends, const Pose& pose) {
  PairSurface surface{body, {}, {}, {}, {}};
  surface.round = contact::RoundSurface{radius, {to_world(pose, ends[0]), to_world(pose, ends[1])}, pose};
  return surface;
}

// A ball in a plate: the heights of vertices and of the lowest point are those of the sphere, whichever
// surface comes first, and material points are those of the turned ball.
TEST(RigidCoupling, BallOnPlate_SitesAreOnSphere) {
  const Placed plate = grid_plate(0.05, 25);
  const Pose pose{{0.0007, -0.0003, 0.0185}, axes_of(rigid::rotation_of({0.2, 1.1, 0}))};
  const PairSurface ball = round_surface(1, 0.02, {{{}, {}}}, pose),
                    mesh{0, plate.rest, plate.x, plate.triangles, {}};
  for (const bool ball_first : {false, true}) {
    const contact::PairParams params{.reach = 0.002, .deepest = 0.01, .capacity = 200};
    const contact::PairSites found = contact::find_pair_sites(
        Exec(1), ball_first ? std::array{ball, mesh} : std::array{mesh, ball}, params, {});
    EXPECT_GT(found.sites.size(), 9U);
    EXPECT_NEAR(found.deepest, 0.0015, 2e-5);
    for (const PairSite& site : found.sites) {
      const contact::SurfacePoint& on_ball = site.a.body == 1 ? site.a : site.b;
      const Vec3d x = to_world(pose, on_ball.rest) + on_ball.offset;
      EXPECT_NEAR(norm(x - pose.position), 0.02, 1e-12);
      EXPECT_NEAR(site.distance, dot(site.normal, site.found), 1e-12);
    }
  }
}

// Capsules that cross touch at one point, parallel ones along their length, and a capsule on the ground at
// both ends.
TEST(RigidCoupling, Capsules_TouchAtNearestPoints) {
  const std::array<Vec3d, 2> ends{{{0, 0, -0.04}, {0, 0, 0.04}}};
  const auto turned = [](Vec3d at, Vec3d turn) { return Pose{at, axes_of(rigid::rotation_of(turn))}; };
  const contact::PairParams params{.reach = 0.002, .deepest = 0.004};
  const PairSurface lower = round_surface(0, 0.005, ends, turned({}, {0, M_PI / 2, 0}));
  const PairSurface crossed = round_surface(1, 0.005, ends, turned({0.01, 0.02, 0.0105}, {M_PI / 2, 0, 0}));
  const contact::PairSites one = contact::find_pair_sites(Exec(1), {lower, crossed}, params, {});
  ASSERT_EQ(one.sites.size(), 1U);
  EXPECT_NEAR(one.sites[0].distance, 0.0005, 1e-9);
  EXPECT_LT(norm(one.sites[0].normal - Vec3d{0, 0, -1}), 1e-6);
  const PairSurface beside = round_surface(1, 0.005, ends, turned({0.01, 0, 0.0102}, {0, M_PI / 2, 0}));
  EXPECT_GE(contact::find_pair_sites(Exec(1), {lower, beside}, params, {}).sites.size(), 2U);
  const contact::PairSites ground =
      contact::find_ground_sites(lower, {.through = {0, 0, -0.0051}}, params, {});
  ASSERT_EQ(ground.sites.size(), 2U);
  EXPECT_NEAR(ground.sites[0].distance, 1e-4, 1e-12);
  EXPECT_TRUE(ground.sites[0].rolls);
}

// Long capsules that cross at small angles, far from their middles: one site, at the distance of their axes.
TEST(RigidCoupling, CapsulesAtSmallAngle_TouchAtCrossing) {
  constexpr double kRadius = 1e-3, kApart = 1.9e-3;
  for (const double degrees : {5.0, 12.0, 1.0}) {
    const double angle = degrees * M_PI / 180;
    const Vec3d first{1, 0, 0}, second{std::cos(angle), std::sin(angle), 0};
    // they cross at the origin, 3 cm from one middle and 2 cm from the other
    const auto capsule = [&](int body, Vec3d along, double middle, double height) {
      const std::array<Vec3d, 2> ends{along * (middle - 0.05) + Vec3d{0, 0, height},
                                      along * (middle + 0.05) + Vec3d{0, 0, height}};
      return round_surface(body, kRadius, ends, Pose{{}, axes_of(rigid::rotation_of({}))});
    };
    const contact::PairSites found =
        contact::find_pair_sites(Exec(1), {capsule(0, second, -0.02, kApart), capsule(1, first, 0.03, 0)},
                                 {.reach = 1e-5, .deepest = 1e-3}, {});
    ASSERT_FALSE(found.sites.empty()) << degrees;
    const PairSite& site =
        *std::min_element(found.sites.begin(), found.sites.end(),
                          [](const PairSite& a, const PairSite& b) { return a.distance < b.distance; });
    EXPECT_NEAR(site.distance, kApart - 2 * kRadius, 1e-9) << degrees;
    EXPECT_NEAR(dot(site.normal, first), 0, 1e-9) << degrees;
    EXPECT_NEAR(dot(site.normal, second), 0, 1e-9) << degrees;
  }
}

/// A box with twelve triangles, counter-clockwise seen from outside.
Placed plain_box(Vec3d size, const Pose& pose) {
  Placed box;
  for (int n = 0; n < 8; n++)
    box.x.push_back(to_world(
        pose, {(n & 1 ? 0.5 : -0.5) * size.x, (n & 2 ? 0.5 : -0.5) * size.y, (n & 4 ? 0.5 : -0.5) * size.z}));
  box.rest = box.x;
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}

// A capsule lies across a box. Vertices and the points along its segment are far from the contact: the edges
// of the face that it crosses have its depth, whether the box is turned or not.
TEST(RigidCoupling, CapsuleAcrossBox_TouchesItsEdges) {
  constexpr double kRadius = 0.004, kHalf = 0.06, kAbove = 0.002;
  for (const double angle : {0.0, 0.3}) {
    const Placed box = plain_box({0.018, 0.03, 0.034},
                                 {{0.015, 0, -0.017 - kAbove}, axes_of(rigid::rotation_of({0, 0, angle}))});
    const PairSurface mesh{0, box.rest, box.x, box.triangles, {}};
    const PairSurface capsule = round_surface(1, kRadius, {{{-kHalf, 0, 0}, {kHalf, 0, 0}}},
                                              Pose{{}, axes_of(rigid::rotation_of({}))});
    const contact::PairSites found =
        contact::find_pair_sites(Exec(1), {mesh, capsule}, {.reach = 1e-3, .deepest = 3e-3}, {});
    double most = -1, least = 1;
    for (const PairSite& site : found.sites) {
      EXPECT_NEAR(site.distance, kAbove - kRadius, 1e-9) << angle;
      const Vec3d up{0, 0, site.a.body == 1 ? 1.0 : -1.0};
      EXPECT_LT(norm(site.normal - up), 1e-9) << angle;
      const double x = (site.a.body == 1 ? site.b : site.a).rest.x;
      most = std::max(most, x), least = std::min(least, x);
    }
    const double half = 0.009 / std::cos(angle);
    EXPECT_NEAR(most, 0.015 + half, 1e-9) << angle;
    EXPECT_NEAR(least, 0.015 - half, 1e-9) << angle;
    EXPECT_LE(found.sites.size(), 4U) << angle;
  }
}

// A capsule on a finely meshed plate has one site for each vertex near it: edges add none.
TEST(RigidCoupling, CapsuleOnFineMesh_TouchesVerticesOnly) {
  const Placed plate = grid_plate(0.05, 50);
  const PairSurface mesh{0, plate.rest, plate.x, plate.triangles, {}};
  const PairSurface capsule = round_surface(1, 0.004, {{{-0.02, 0, 0.0035}, {0.02, 0, 0.0035}}},
                                            Pose{{}, axes_of(rigid::rotation_of({}))});
  const contact::PairSites found = contact::find_pair_sites(
      Exec(1), {mesh, capsule}, {.reach = 1e-3, .deepest = 3e-3, .capacity = 400}, {});
  ASSERT_GT(found.sites.size(), 20U);
  for (const PairSite& site : found.sites) EXPECT_FALSE(site.rolls);
}

}  // namespace
}  // namespace turgor

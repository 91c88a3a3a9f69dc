#include "turgor/contact/touch.hpp"

#include <cmath>
#include <cstdlib>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "tests/contact/touched_half_space.hpp"
#include "turgor/geometry/ball_mesh.hpp"

using turgor::test::allocations;

namespace turgor::contact {
namespace {

// The force of a rigid sphere is within 2 % of Hertz.
TEST(Touch, RigidSphereMatchesHertz) {
  const HalfSpace s{.side = 33, .spacing = 0.25e-3, .young = 1e4, .poisson = 0.3};
  const double stiff = s.young / (1 - s.poisson * s.poisson), radius = 0.1;  // large against the contact
  for (const double contact : {0.7e-3, 1e-3, 1.4e-3}) {
    const double depth = contact * contact / radius;
    Touched scene(s, {{Sphere{radius}, 0}}, {.capacity = 160});
    const double force = scene.settle({0, 0, radius - depth}).force.z;
    const double hertz = 4.0 / 3 * stiff * std::sqrt(radius) * std::pow(depth, 1.5);
    EXPECT_NEAR(force / hertz, 1, 0.02) << depth;
    std::printf("contact radius %.1f mm: %.3e N, Hertz %.3e N (%+.1f %%), %d contacts\n", 1e3 * contact,
                force, hertz, 100 * (force / hertz - 1), scene.forces[0].contacts);
  }
}

// A lying capsule of twice the length has between 1.4 and 2 times the force.
TEST(Touch, CapsuleForceGrowsWithLength) {
  const HalfSpace s{.side = 31, .spacing = 0.5e-3};
  const Mat3d lying{{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
  double force[2];
  for (int i = 0; i < 2; i++) {
    Touched scene(s, {{Capsule{2e-3, 2e-3 * (i + 1)}, 0}}, {.capacity = 128});
    const std::vector<ToolPose> poses{{{{0, 0, 1.8e-3}, lying}, false}};
    for (int tick = 0; tick < 10; tick++)
      solve_touch_tick(scene.patch, scene.state, scene.tools, poses, kTick, scene.forces);
    force[i] = scene.forces[0].force.z;
    EXPECT_NEAR(norm(scene.forces[0].torque), 0, 1e-3 * force[i] * 2e-3);
  }
  EXPECT_GT(force[1] / force[0], 1.4);
  EXPECT_LT(force[1] / force[0], 2.0);
}

// A ball of triangles has the force of a sphere within 5 %.
TEST(Touch, MeshBallMatchesSphere) {
  const Result<Shape> ball = mesh_shape(ball_mesh(kRadius, 4), 64);
  ASSERT_TRUE(ball) << ball.error().message;
  Touched sphere({.side = 15}, {{Sphere{kRadius}, 0.3}}, {.capacity = 64});
  Touched mesh({.side = 15}, {{*ball, 0.3}}, {.capacity = 64});
  for (const double depth : {0.5e-3, 1e-3}) {
    const double exact = sphere.settle(above(0.2e-3, 0, depth)).force.z;
    EXPECT_NEAR(mesh.settle(above(0.2e-3, 0, depth)).force.z / exact, 1, 0.05) << depth;
  }
  const double jump = mesh.move(above(0.2e-3, 0, 1e-3), above(3e-3, 0, 1e-3));
  EXPECT_LT(jump, 0.05 * mesh.forces[0].force.z);
}

// A tool that is far away or has just separated has no force.
TEST(Touch, SeparatedToolHasNoForce) {
  Touched scene({}, {{Sphere{kRadius}, 0.3}});
  EXPECT_EQ(scene.press({0, 0, 1}).force, Vec3d{});
  scene.settle(above(0, 0, 0));
  EXPECT_EQ(scene.forces[0].force, Vec3d{});
  EXPECT_GT(scene.settle(above(0, 0, 1e-3)).force.z, 0);
  scene.settle(above(0, 0, -1e-6));
  EXPECT_EQ(scene.forces[0].force, Vec3d{});
  for (const Vec3d u : scene.state.u) EXPECT_EQ(u, Vec3d{});
}

// No point remains inside the tool.
TEST(Touch, NoPointPenetratesTool) {
  Touched scene({.side = 15}, {{Sphere{kRadius}, 0.3}}, {.capacity = 64});
  const ToolForce haptic = scene.settle(above(0.3e-3, 0.1e-3, 1.5e-3), 30);
  EXPECT_LT(haptic.largest_penetration, 1e-6);
  EXPECT_GT(haptic.contacts, 10);
  EXPECT_EQ(haptic.dropped, 0);
}

// The contact pressure integrates to the force, and the forces on all points balance the tool's force.
TEST(Touch, PressureIntegratesToForce) {
  Touched scene({.side = 15}, {{Sphere{kRadius}, 0.3}}, {.capacity = 64});
  const ToolForce haptic = scene.settle(above(0, 0, 1e-3));
  std::vector<double> pressure(scene.state.x.size());
  contact_pressure(scene.state.surface, scene.state.force, pressure);
  double sum = 0;
  for (std::size_t i = 0; i < pressure.size(); i++) sum += pressure[i] * scene.state.surface.area[i];
  EXPECT_NEAR(sum, haptic.force.z, 1e-12);
  EXPECT_NEAR(haptic.area, haptic.contacts * 1e-6, 1e-12);
  Vec3d on_points;
  for (const Vec3d f : scene.state.force) on_points += f;
  EXPECT_NEAR(norm(on_points + haptic.force), 0, 1e-12);
}

// A short drag sticks below the friction limit; a long one slides at the cone.
TEST(Touch, ShortDragSticksLongDragSlides) {
  Touched scene({.side = 15}, {{Sphere{kRadius}, 0.4}}, {.capacity = 64});
  const Vec3d first = scene.settle(above(0, 0, 1e-3), 200).force;
  scene.move(above(0, 0, 1e-3), above(5e-5, 0, 1e-3));
  EXPECT_LT(scene.forces[0].force.x, -0.02 * first.z);  // resists the drag
  EXPECT_LT(std::abs(scene.forces[0].force.x), 0.4 * first.z);
  scene.move(above(5e-5, 0, 1e-3), above(3e-3, 0, 1e-3));
  const ToolForce haptic = scene.forces[0];
  EXPECT_EQ(haptic.sliding, haptic.contacts);
  // The normals of a sphere differ, so the ratio of the total forces is near μ, not equal to it.
  EXPECT_NEAR(-haptic.force.x / haptic.force.z, 0.4, 0.1);
}

// A sticking contact keeps its force for ten thousand ticks.
TEST(Touch, StickingForceIsConstant) {
  Touched scene({.side = 11}, {{Sphere{kRadius}, 1.5}}, {.capacity = 64});
  scene.settle(above(0, 0, 0.5e-3), 50);
  scene.move(above(0, 0, 0.5e-3), above(1e-4, 0, 0.5e-3));
  const Vec3d first = scene.settle(above(1e-4, 0, 0.5e-3), 50).force;
  const Vec3d last = scene.settle(above(1e-4, 0, 0.5e-3), 10000).force;
  EXPECT_LT(norm(last - first), 1e-6 * norm(first));
  EXPECT_LT(first.x, 0);
}

// Held points pull the tool until they are released.
TEST(Touch, HeldPointsPullUntilReleased) {
  Touched scene({.side = 11}, {{Sphere{kRadius}, 0.3}}, {.capacity = 64});
  scene.settle(above(0, 0, 0.5e-3));
  scene.move(above(0, 0, 0.5e-3), above(0, 0, -1e-3), true);
  EXPECT_LT(scene.forces[0].force.z, 0) << "the body pulls the tool down";
  EXPECT_GT(scene.state.u[60].z, 0.5e-3) << "the middle point is lifted";
  const Vec3d pulled = scene.forces[0].force;
  scene.move(above(0, 0, -1e-3), above(1e-3, 0, -1e-3), true);
  EXPECT_LT(scene.forces[0].force.x, 0);
  scene.move(above(1e-3, 0, -1e-3), above(0, 0, -1e-3), true);
  EXPECT_LT(norm(scene.forces[0].force - pulled), 1e-9 * norm(pulled))
      << "elastic: the force is independent of the path";
  EXPECT_EQ(scene.press(above(0, 0, -1e-3), false).force, Vec3d{});
}

// Held sites move exactly with the tool.
TEST(Touch, HeldSitesMoveWithTool) {
  Touched scene({.side = 11}, {{Sphere{kRadius}, 0.3}}, {.capacity = 64});
  scene.settle(above(0, 0, 0.5e-3));
  const Vec3d before = scene.state.x[60];
  scene.move(above(0, 0, 0.5e-3), above(2e-4, 1e-4, -1e-3), true);
  EXPECT_LT(norm(scene.state.x[60] - before - Vec3d{2e-4, 1e-4, 1.5e-3}), 1e-12);
}

// Two near tools reduce each other's force; distant tools hardly do.
TEST(Touch, NearToolsReduceEachOthersForce) {
  const HalfSpace s{.side = 31};
  const auto force = [&](double apart, bool second) {
    Touched scene(s, {{Sphere{kRadius}, 0}, {Sphere{kRadius}, 0}}, {.capacity = 64});
    const std::vector<ToolPose> poses{{{above(-apart / 2, 0, 0.5e-3), {}}, false},
                                      {{second ? above(apart / 2, 0, 0.5e-3) : Vec3d{0, 0, 1}, {}}, false}};
    for (int i = 0; i < 10; i++)
      solve_touch_tick(scene.patch, scene.state, scene.tools, poses, kTick, scene.forces);
    return scene.forces[0].force.z;
  };
  EXPECT_LT(force(8e-3, true), 0.95 * force(8e-3, false));
  EXPECT_GT(force(24e-3, true), 0.94 * force(24e-3, false));
}

// A tool smaller than the triangles has contact between their points.
TEST(Touch, SmallToolTouchesBetweenPoints) {
  Touched scene({.side = 7, .spacing = 10e-3}, {{Sphere{2e-3}, 0.3}});
  for (const Vec3d at : {Vec3d{6.5e-3, 3e-3, 1.5e-3}, Vec3d{5e-3, 0, 1.5e-3}, Vec3d{3e-3, 3e-3, 1.5e-3}}) {
    const ToolForce haptic = scene.settle(at, 50);
    EXPECT_GT(haptic.force.z, 0);
    EXPECT_GE(haptic.contacts, 1);
    scene.settle({0, 0, 1});
  }
}

// A small tool slides over edges and points of large triangles without force jumps.
TEST(Touch, SmallToolSlidesOverEdges) {
  Touched scene({.side = 7, .spacing = 10e-3}, {{Sphere{4e-3}, 0.0}});
  const auto at = [](double x) { return Vec3d{x, 0.31 * x + 1e-4, 3.5e-3}; };
  const double force = scene.settle(at(-0.02), 50).force.z;
  const double jump = scene.move(at(-0.02), at(0.02));
  std::printf("sliding over 10 mm triangles: force %.5f N, largest jump per 10 um %.6f N (%.2f %%)\n", force,
              jump, 100 * jump / force);
  EXPECT_LT(jump, 0.02 * force);
}

// The force is continuous while the tool presses, slides and releases.
TEST(Touch, ForceIsContinuous) {
  for (const double friction : {0.0, 0.3}) {
    Touched scene({.side = 21}, {{Sphere{kRadius}, friction}}, {.capacity = 64});
    const double down = scene.move(above(0, 0, -1e-4), above(0, 0, 1e-3));
    const double force = norm(scene.forces[0].force);
    const double slide = scene.move(above(0, 0, 1e-3), above(4e-3, 1e-3, 1e-3));
    const double up = scene.move(above(4e-3, 1e-3, 1e-3), above(4e-3, 1e-3, -1e-3));
    std::printf(
        "friction %.1f: force %.4f N; largest jump per 10 um: press %.5f, slide %.5f, release %.5f N\n",
        friction, force, down, slide, up);
    EXPECT_LT(std::max({down, slide, up}), 0.05 * force);
    EXPECT_EQ(scene.forces[0].force, Vec3d{});
  }
}

// A press deeper than the radius keeps its force; at three radii the tool does not fall through.
TEST(Touch, DeepPressDoesNotFallThrough) {
  for (const double friction : {0.0, 0.3}) {
    constexpr double kSmall = 2e-3;
    Touched scene({.side = 21}, {{Sphere{kSmall}, friction}}, {.capacity = 64});
    double most = 0;
    for (int i = 1; i <= 60; i++) {
      const double force = scene.press({0.2e-3, 0.1e-3, kSmall - i * 1e-4}).force.z;
      EXPECT_GE(force, (i <= 28 ? 1 : i <= 40 ? 0.8 : 0.3) * most) << friction << " " << i;
      most = std::max(most, force);
    }
  }
}

// A tool that starts inside the body has no force until it has left the body once.
TEST(Touch, ToolStartingInsideHasNoForce) {
  Touched scene({.side = 21}, {{Sphere{kRadius}, 0.3}}, {.capacity = 64});
  const ToolForce haptic = scene.press({0, 0, -3e-3});
  EXPECT_TRUE(haptic.inside);
  EXPECT_EQ(haptic.force, Vec3d{});
  scene.move({0, 0, -3e-3}, above(0, 0, 0.1e-3));
  EXPECT_TRUE(scene.forces[0].inside);
  scene.move(above(0, 0, 0.1e-3), above(0, 0, -0.1e-3));
  EXPECT_FALSE(scene.forces[0].inside);
  scene.move(above(0, 0, -0.1e-3), above(0, 0, 0.5e-3));
  EXPECT_GT(scene.forces[0].force.z, 0);
}

// A tool that moves 7 mm in one tick does not fall through.
TEST(Touch, FastToolDoesNotFallThrough) {
  Touched scene({.side = 21}, {{Sphere{2e-3}, 0.0}}, {.capacity = 64});
  scene.press({0, 0, 4e-3});
  EXPECT_GT(scene.press({0, 0, -3e-3}).force.z, 0) << "7 mm in one tick";
  EXPECT_LT(scene.state.x[220].z, -4e-3);
}

// An invalid pose gives no force and sets a flag; the next valid pose restores the force.
TEST(Touch, InvalidPoseHasNoForceAndFlag) {
  Touched scene({}, {{Sphere{kRadius}, 0.3}});
  const double force = scene.settle(above(0, 0, 1e-3)).force.z;
  for (const Vec3d bad : {Vec3d{NAN, 0, 0}, Vec3d{0, INFINITY, 0}}) {
    const ToolForce haptic = scene.press(bad);
    EXPECT_TRUE(haptic.invalid_pose);
    EXPECT_EQ(haptic.force, Vec3d{});
  }
  const std::vector<ToolPose> squeezed{{{above(0, 0, 1e-3), {{{1, 0, 0}, {0, 1, 0}, {0, 0, 2}}}}, false}};
  solve_touch_tick(scene.patch, scene.state, scene.tools, squeezed, kTick, scene.forces);
  EXPECT_TRUE(scene.forces[0].invalid_pose);
  EXPECT_NEAR(scene.settle(above(0, 0, 1e-3)).force.z, force, 1e-6 * force);
}

// A tool that reaches beyond the patch sets a flag.
TEST(Touch, ToolBeyondPatchSetsFlag) {
  Touched scene({.side = 5}, {{Sphere{50e-3}, 0.3}});
  EXPECT_TRUE(scene.settle({0, 0, 49e-3}).beyond_patch);
  Touched small({.side = 15}, {{Sphere{kRadius}, 0.3}}, {.capacity = 64});
  EXPECT_FALSE(small.settle(above(0, 0, 1e-3)).beyond_patch);
}

// Sites beyond the capacity are dropped and counted.
TEST(Touch, CountsDroppedSites) {
  Touched scene({.side = 21}, {{Sphere{20e-3}, 0.3}}, {.capacity = 8});
  const ToolForce haptic = scene.press({0, 0, 19e-3});
  EXPECT_LE(haptic.contacts, 8);
  EXPECT_GT(haptic.dropped, 0);
}

// An external displacement moves the surface under the tool.
TEST(Touch, OffsetMovesSurface) {
  Touched scene({.side = 15}, {{Sphere{kRadius}, 0.0}}, {.capacity = 64});
  const double force = scene.settle(above(0, 0, 1e-3)).force.z;
  Touched lifted({.side = 15}, {{Sphere{kRadius}, 0.0}}, {.capacity = 64});
  lifted.state.offset.assign(lifted.state.offset.size(), {0, 0, 0.4e-3});
  EXPECT_NEAR(lifted.settle(above(0, 0, 0.6e-3)).force.z, force, 1e-6 * force);
}

// A tick allocates no memory.
TEST(Touch, TicksAllocateNothing) {
  Touched scene({.side = 15}, {{Sphere{kRadius}, 0.3}, {Capsule{1e-3, 3e-3}, 0.3}},
                {.capacity = 32, .viscosity = one_pair(1, 0.1)});
  std::vector<ToolPose> poses(2);
  std::size_t counted = 0;
  for (int i = 0; i < 400; i++) {
    const double x = 2e-3 * std::sin(0.05 * i);
    poses[0] = {{above(x, 0, 0.8e-3), {}}, i > 200 && i < 300};
    poses[1] = {{{-x, 4e-3, i % 50 == 0 ? NAN : 3.5e-3}, {}}, false};
    const std::size_t before = allocations;
    solve_touch_tick(scene.patch, scene.state, scene.tools, poses, kTick, scene.forces);
    counted += allocations - before;
  }
  EXPECT_EQ(counted, 0u);
  EXPECT_GT(allocations, 0u);
}

// Clusters of points have the force of all points and allocate no memory.
TEST(Touch, ClustersMatchAllPoints) {
  const auto pressed = [](int capacity) {
    Touched scene({.side = 21}, {{Sphere{20e-3}, 0.3}}, {.capacity = capacity});
    sfem::add_levels(scene.patch);
    return scene;
  };
  Touched all = pressed(300), few = pressed(32);
  std::size_t counted = 0;
  int coarsest = 0;
  for (int i = 1; i <= 200; i++) {
    const Vec3d at{0, 0, 20e-3 - 1.5e-5 * (i <= 100 ? i : 200 - i)};
    const std::vector<ToolPose> poses{{{at, {}}, false}};
    const std::size_t before = allocations;
    solve_touch_tick(few.patch, few.state, few.tools, poses, kTick, few.forces);
    counted += allocations - before;
    const ToolForce haptic = few.forces[0];
    const ToolForce exact = all.press(at);
    coarsest = std::max(coarsest, haptic.level);
    EXPECT_EQ(haptic.dropped, 0);
    EXPECT_EQ(exact.level, 0);
    EXPECT_LE(haptic.contacts, 32);
    // While the tool retracts, clusters stay coarse a little longer: hysteresis avoids switching back and
    // forth.
    EXPECT_NEAR(haptic.force.z, exact.force.z, (i <= 100 ? 0.03 : 0.05) * exact.force.z + 2e-4) << i;
  }
  EXPECT_EQ(counted, 0u);
  EXPECT_GE(coarsest, 2);
  few.settle(above(0, 0, -1e-3) + Vec3d{0, 0, 15e-3}, 6);
  EXPECT_EQ(few.forces[0].level, 0) << "points again after the release";
}

// Equal paths give equal bits.
TEST(Touch, EqualPathsGiveEqualBits) {
  std::vector<Vec3d> forces[2];
  for (auto& list : forces) {
    Touched scene({.side = 11}, {{Sphere{kRadius}, 0.3}}, {.viscosity = one_pair(1, 0.1)});
    for (int i = 0; i < 300; i++)
      list.push_back(scene.press(above(1e-5 * i, 2e-6 * i, 1e-3 * std::sin(0.03 * i))).force);
  }
  EXPECT_EQ(forces[0], forces[1]);
}

}  // namespace
}  // namespace turgor::contact

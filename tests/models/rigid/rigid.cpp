// Free motion of rigid bodies against closed forms.
#include "turgor/models/rigid/rigid.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/elliptic.hpp"
#include "turgor/geometry/ball_mesh.hpp"

namespace turgor {
namespace {

constexpr double kFrame = 1.0 / 60;

/// A body of given principal moments along tilted axes.
rigid::Model body_of(Vec3d moments, double mass = 0.7) {
  rigid::Model model;
  model.mass = {.mass = mass,
                .center = {0.3, -0.2, 0.1},
                .axes = axes_of(rigid::rotation_of({0.4, -0.9, 1.3})),
                .moments = moments};
  return model;
}

/// Vertices and triangles of a box around the origin.
rigid::Model box_mesh(Vec3d size) {
  rigid::Model model;
  for (int n = 0; n < 8; n++)
    model.vertices.push_back(
        {((n & 1) - 0.5) * size.x, ((n >> 1 & 1) - 0.5) * size.y, ((n >> 2) - 0.5) * size.z});
  model.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return model;
}

// Torque-free rotation of an asymmetric body over ten minutes: the momentum stays, and the energy error is
// bounded.
TEST(RigidBody, TorqueFree_KeepsMomentumAndEnergy) {
  const rigid::Model model = body_of({2e-4, 5e-4, 6e-4});
  rigid::State state = rigid::make_state(model, {0.1, 0.2, -0.3}, {4, -7, 3});
  const Vec3d momentum = state.momentum;
  const double energy = rigid::kinetic_energy(model, state);
  double worst = 0;
  for (int n = 0; n < 36000; n++) {
    state = rigid::moved(model, state, {}, {}, kFrame);
    worst = std::max(worst, std::abs(rigid::kinetic_energy(model, state) / energy - 1));
  }
  std::printf("energy error at most %.2g\n", worst);
  EXPECT_LT(norm(state.momentum - momentum), 1e-12 * norm(momentum));
  EXPECT_LT(worst, 1e-6);
  EXPECT_LT(norm(state.center - model.mass.center - Vec3d{0.1, 0.2, -0.3} * 600.0), 1e-9);
}

// A body that spins about its middle axis flips over again and again, at the period of Euler's equations:
// between flips 2 K(m)/λ seconds pass, with K from the energy and the momentum [Landau, Lifshitz, Mechanics
// §37].
TEST(RigidBody, MiddleAxis_FlipsAtPeriodOfEuler) {
  for (const double angle : {0.02, 0.3}) {
    const Vec3d j{2e-4, 5e-4, 6e-4};
    const rigid::Model model = body_of(j);
    // nearly about the middle axis, tilted toward the third
    const Mat3d& axes = model.mass.axes;
    const Vec3d spin = 9.0 * (std::cos(angle) * axes.column[1] + std::sin(angle) * axes.column[2]);
    rigid::State state = rigid::make_state(model, {}, spin);
    const double twice_energy = 2 * rigid::kinetic_energy(model, state),
                 m2 = dot(state.momentum, state.momentum);
    const bool is_above = m2 > twice_energy * j.y;  // else the axes 1 and 3 change roles
    const double a = is_above ? j.x : j.z, c = is_above ? j.z : j.x;
    const double rate = std::sqrt((c - j.y) * (m2 - twice_energy * a) / (j.x * j.y * j.z));
    const double parameter = (j.y - a) * (twice_energy * c - m2) / ((c - j.y) * (m2 - twice_energy * a));
    const double expected = 2 * test::elliptic_k(parameter) / rate;
    // times at which the spin about the middle axis changes its sign
    double before = 0, first = 0, last = 0;
    int flips = 0;
    for (int n = 0; n < 12000; n++) {
      const double now = dot(axes_of(state.rotation) * axes.column[1], state.momentum);
      if (n > 0 && now * before < 0) {
        last = (n - 1 + before / (before - now)) * kFrame;
        if (flips++ == 0) first = last;
      }
      before = now;
      state = rigid::moved(model, state, {}, {}, kFrame);
    }
    const double period = (last - first) / (flips - 1);
    std::printf("%d flips, %.5f s apart, expected %.5f s\n", flips, period, expected);
    EXPECT_GT(flips, 20);
    EXPECT_NEAR(period, expected, 2e-3 * expected);
  }
}

// A symmetric top precesses about its momentum at the rate L/J.
TEST(RigidBody, SymmetricTop_Precesses) {
  const rigid::Model model = body_of({3e-4, 3e-4, 5e-4});
  const Vec3d axis = model.mass.axes.column[2];
  rigid::State state = rigid::make_state(model, {}, 12.0 * axis + 5.0 * model.mass.axes.column[0]);
  const Vec3d along = normalized(state.momentum);
  const double angle = norm(state.momentum) / 3e-4 * 300 * kFrame;
  for (int n = 0; n < 300; n++) state = rigid::moved(model, state, {}, {}, kFrame);
  const Vec3d expected =
      axes_of(rigid::rotation_of(along * std::remainder(angle, 2 * std::numbers::pi))) * axis;
  EXPECT_LT(norm(axes_of(state.rotation) * axis - expected), 1e-3);
}

// Mass, center and moments of a box, of a tilted one, and of a ball and a capsule of triangles.
TEST(RigidBody, MassOfMesh_IsThatOfShape) {
  const Vec3d size{0.02, 0.05, 0.03};
  rigid::Model box = box_mesh(size);
  const Mat3d axes = axes_of(rigid::rotation_of({0.2, 0.5, -0.4}));
  for (Vec3d& x : box.vertices) x = axes * x + Vec3d{1, 2, 3};
  const rigid::MassProperties made = *rigid::mass_of_mesh(box.vertices, box.triangles, 800);
  const double mass = 800 * 0.02 * 0.05 * 0.03;
  EXPECT_NEAR(made.mass, mass, 1e-9 * mass);
  EXPECT_LT(norm(made.center - Vec3d{1, 2, 3}), 1e-9);
  // ascending moments: about y, z and x
  const double expected[] = {mass / 12 * (0.02 * 0.02 + 0.03 * 0.03), mass / 12 * (0.02 * 0.02 + 0.05 * 0.05),
                             mass / 12 * (0.05 * 0.05 + 0.03 * 0.03)};
  for (int axis = 0; axis < 3; axis++) EXPECT_NEAR(made.moments[axis], expected[axis], 1e-6 * expected[axis]);
  EXPECT_NEAR(std::abs(dot(made.axes.column[0], axes.column[1])), 1, 1e-9);

  const TriMesh ball = ball_mesh(0.02F, 5);
  const std::vector<Vec3d> vertices = [&] {
    std::vector<Vec3d> x;
    for (const Vec3 v : ball.vertices) x.push_back(Vec3d(v));
    return x;
  }();
  const rigid::MassProperties of_mesh = *rigid::mass_of_mesh(vertices, ball.triangles, 1000);
  const rigid::MassProperties exact = rigid::mass_of_round({.radius = 0.02, .ends = {}}, 1000);
  EXPECT_NEAR(exact.moments.x, 0.4 * exact.mass * 0.02 * 0.02, 1e-12 * exact.mass);
  EXPECT_NEAR(of_mesh.mass, exact.mass, 0.005 * exact.mass);
  EXPECT_NEAR(of_mesh.moments.y, exact.moments.y, 0.01 * exact.moments.y);
}

// A capsule is a cylinder with two half balls: its properties by slices across the axis.
TEST(RigidBody, MassOfCapsule_IsSumOfSlices) {
  const double r = 0.01, half = 0.03;
  const rigid::MassProperties made =
      rigid::mass_of_round({.radius = r, .ends = {{{0, -half, 0}, {0, half, 0}}}}, 1100);
  double mass = 0, about = 0, across = 0;
  constexpr int kSlices = 200000;
  for (int n = 0; n < kSlices; n++) {
    const double thickness = 2 * (half + r) / kSlices, y = -half - r + (n + 0.5) * thickness;
    const double past = std::max(0.0, std::abs(y) - half), square = r * r - past * past;
    const double slice = 1100 * std::numbers::pi * square * thickness;
    mass += slice, about += slice * square / 2, across += slice * (square / 4 + y * y);
  }
  EXPECT_NEAR(made.mass, mass, 1e-6 * mass);
  EXPECT_NEAR(made.moments.x, about, 1e-6 * about);
  EXPECT_NEAR(made.moments.z, across, 1e-6 * across);
}

// A surface that is inside out has no mass.
TEST(RigidBody, InvertedMesh_IsRefused) {
  rigid::Model box = box_mesh({0.1, 0.1, 0.1});
  for (Int3& t : box.triangles) std::swap(t.x, t.y);
  EXPECT_FALSE(rigid::mass_of_mesh(box.vertices, box.triangles, 1000));
}

}  // namespace
}  // namespace turgor

// Forces and stiffnesses of one element against finite differences of its energy.
#include "turgor/models/lattice/mechanics/element_energies.hpp"

#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

using Energy = std::function<double(Vec3d)>;

Vec3d minus_gradient(const Energy& energy, Vec3d x) {
  Vec3d g;
  for (int axis = 0; axis < 3; axis++) {
    constexpr double h = 1e-5;
    Vec3d a = x, b = x;
    a[axis] += h, b[axis] -= h;
    g[axis] = -(energy(a) - energy(b)) / (2 * h);
  }
  return g;
}

struct Random {
  std::mt19937 engine{1};
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(engine); }
  Vec3d point() { return {(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)}; }
};

bool is_positive_definite(const NodeSystem& s) {
  const double minor2 = double(s.xx) * s.yy - double(s.xy) * s.xy;
  const double det = double(s.xx) * (double(s.yy) * s.zz - double(s.yz) * s.yz) -
                     double(s.xy) * (double(s.xy) * s.zz - double(s.yz) * s.xz) +
                     double(s.xz) * (double(s.xy) * s.yz - double(s.yy) * s.xz);
  return s.xx >= 0 && minor2 >= -1e-4 && det >= -1e-3;
}

void expect_near(Vec3d found, Vec3d expected, double tolerance) {
  for (int axis = 0; axis < 3; axis++) EXPECT_NEAR(found[axis], expected[axis], tolerance) << "axis " << axis;
}

double amplified(double s, double r, double beta) {
  return s * s / 2 + (s > 0 ? beta * s * s * s / (3 * r) : 0);
}

// The force of a spring is the negative gradient of its energy; its matrix is positive definite.
TEST(ElementEnergies, SpringForceIsGradient) {
  Random random;
  for (int n = 0; n < 200; n++) {
    const Vec3d a = random.point(), b = random.point();
    const double rest = random(0.2, 2), k = random(1, 3);
    NodeSystem s;
    add_spring(s, Vec3(b - a), Real(rest), Real(k));
    const Energy energy = [&](Vec3d x) { return 0.5 * k * (norm(b - x) - rest) * (norm(b - x) - rest); };
    expect_near(Vec3d(s.f), minus_gradient(energy, a), 1e-4);
    EXPECT_TRUE(is_positive_definite(s));
  }
}

// Volume gradients match finite differences of the volume.
TEST(ElementEnergies, VolumeGradients) {
  Random random;
  for (int n = 0; n < 200; n++) {
    const Vec3d a = random.point(), b = random.point(), c = random.point(), d = random.point();
    const VolumeGradients g = volume_gradients(Vec3(b - a), Vec3(c - a), Vec3(d - a));
    const auto volume = [](Vec3d p, Vec3d q, Vec3d r, Vec3d s) {
      return dot(q - p, cross(r - p, s - p));
    };  // sixths
    expect_near(-Vec3d(g.g1), minus_gradient([&](Vec3d x) { return volume(a, x, c, d); }, b), 1e-4);
    expect_near(-Vec3d(g.g2), minus_gradient([&](Vec3d x) { return volume(a, b, x, d); }, c), 1e-4);
    expect_near(-Vec3d(g.g3), minus_gradient([&](Vec3d x) { return volume(a, b, c, x); }, d), 1e-4);
    expect_near(Vec3d(g.g1 + g.g2 + g.g3), minus_gradient([&](Vec3d x) { return volume(x, b, c, d); }, a),
                1e-4);
  }
}

// Forces of area skin are the negative gradient of its energy and sum to zero.
TEST(ElementEnergies, AreaSkinForceIsGradient) {
  Random random;
  for (int n = 0; n < 200; n++) {
    const Vec3d x[3] = {random.point(), random.point(), random.point()};
    const double area = 0.5 * norm(cross(x[1] - x[0], x[2] - x[0]));
    if (area < 0.1) continue;  // gradients of slivers are beyond single precision
    const double rest = area * random(0.6, 1.4), k = random(1, 3), beta = 2;
    const CornerForces all =
        skin_area_forces(Vec3(x[1] - x[0]), Vec3(x[2] - x[0]), Real(rest), Real(k), Real(beta));
    Vec3d sum;
    for (int c = 0; c < 3; c++) {
      const Vec3d b = x[(c + 1) % 3], d = x[(c + 2) % 3];
      NodeSystem s;
      add_skin_area(s, Vec3(x[c]), Vec3(b), Vec3(d), Real(rest), Real(k), Real(beta));
      const Energy energy = [&](Vec3d p) {
        return k * amplified(0.5 * norm(cross(b - p, d - p)) - rest, rest, beta);
      };
      expect_near(Vec3d(s.f), minus_gradient(energy, x[c]), 2e-4);
      expect_near(Vec3d(all.on[c]), minus_gradient(energy, x[c]), 2e-4);
      EXPECT_TRUE(is_positive_definite(s));
      sum += Vec3d(s.f);
    }
    expect_near(sum, {}, 1e-4);
  }
}

// Forces of fiber skin are the negative gradient of its energy and sum to zero.
TEST(ElementEnergies, FiberSkinForceIsGradient) {
  Random random;
  for (int n = 0; n < 200; n++) {
    SkinTriangle t{};
    t.area = Real(random(0.5, 1));
    for (Real* coefficients : {t.along, t.across}) {
      coefficients[1] = Real(random(-1, 1)), coefficients[2] = Real(random(-1, 1));
      coefficients[0] = -coefficients[1] - coefficients[2];
    }
    const FiberLaw law{
        .rest_along = 0.8f, .rest_across = 0.9f, .stiffness = 3, .shear = 1, .amplification = 2};
    Vec3d x[3] = {random.point(), random.point(), random.point()};
    const CornerForces all =
        skin_fiber_forces(Vec3(x[1] - x[0]), Vec3(x[2] - x[0]), {t.along[0], t.along[1], t.along[2]},
                          {t.across[0], t.across[1], t.across[2]}, t.area, law);
    Vec3d sum;
    for (int c = 0; c < 3; c++) {
      const int next = (c + 1) % 3, last = (c + 2) % 3;
      NodeSystem s;
      add_skin_fiber(s, Vec3(x[next] - x[c]), Vec3(x[last] - x[c]),
                     {t.along[c], t.along[next], t.along[last]},
                     {t.across[c], t.across[next], t.across[last]}, t.area, law);
      const Energy energy = [&](Vec3d p) {
        Vec3d q[3] = {x[0], x[1], x[2]}, along, across;
        q[c] = p;
        for (int i = 0; i < 3; i++) along += q[i] * double(t.along[i]), across += q[i] * double(t.across[i]);
        const double shear = dot(along, across);
        return t.area *
               (3 * amplified(norm(along) - law.rest_along, law.rest_along, 2) +
                3 * amplified(norm(across) - law.rest_across, law.rest_across, 2) + 0.5 * shear * shear);
      };
      expect_near(Vec3d(s.f), minus_gradient(energy, x[c]), 1e-3);
      expect_near(Vec3d(all.on[c]), minus_gradient(energy, x[c]), 1e-3);
      sum += Vec3d(s.f);
    }
    expect_near(sum, {}, 1e-3);
  }
}

// The projection of skin restores the area to second order.
TEST(ElementEnergies, SkinProjectionRestoresArea) {
  Random random;
  for (int n = 0; n < 100; n++) {
    const Vec3d corner[3] = {random.point(), random.point(), random.point()};
    const double area = 0.5 * norm(cross(corner[1] - corner[0], corner[2] - corner[0]));
    if (area < 0.2) continue;
    for (const double change : {0.02, 0.01}) {
      Vec3 x[3] = {Vec3(corner[0]), Vec3(corner[1]), Vec3(corner[2])};
      const double rest = area * (1 - change);
      const SkinShift shift = project_skin(x[0], x[1], x[2], {1, 1, 1}, Real(rest), 1, 0);
      x[0] += shift.a, x[1] += shift.b, x[2] += shift.c;
      const double after = 0.5 * norm(cross(Vec3d(x[1] - x[0]), Vec3d(x[2] - x[0])));
      EXPECT_LT(std::abs(after - rest), 3 * change * change * area) << "area " << area;
    }
  }
}

// Projections conserve the linear and angular momentum of equal masses.
TEST(ElementEnergies, ProjectionsConserveMomentum) {
  Random random;
  for (int n = 0; n < 100; n++) {
    const Vec3 before[3] = {Vec3(random.point()), Vec3(random.point()), Vec3(random.point())};
    const Real area = Real(0.5) * norm(cross(before[1] - before[0], before[2] - before[0]));
    if (area < 0.1f) continue;
    const SkinShift shift = project_skin(before[0], before[1], before[2], {1, 1, 1}, Real(0.9) * area, 1, 2);
    Vec3d linear, angular;
    const Vec3 shifts[3] = {shift.a, shift.b, shift.c};
    for (int c = 0; c < 3; c++) {
      const Vec3d moved(shifts[c]);
      linear += moved;
      angular += cross(Vec3d(before[c]), moved);
    }
    expect_near(linear, {}, 1e-6);
    expect_near(angular, {}, 1e-6);

    const Vec3 d = before[1] - before[0];
    const Real s = project_spring(d, 1, 1, 2, 3);
    EXPECT_NEAR(double(norm(d - d * (s * (2 + 3)))), 1, 1e-5) << "a stiff spring reaches its rest length";
  }
}

// A Newton step does not move a fixed node.
TEST(ElementEnergies, NewtonStepKeepsFixedNode) {
  NodeSystem s;
  add_spring(s, {1, 2, 3}, 1, 1e6f);
  const Vec3 moved = newton_step(s, {0, 0, 0}, 0);
  EXPECT_EQ(moved, (Vec3{0, 0, 0}));
}

}  // namespace
}  // namespace turgor::lattice

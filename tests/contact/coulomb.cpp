#include "turgor/contact/coulomb.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "tests/contact/half_space.hpp"

namespace turgor::contact {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Case {
  MatrixXd c;
  VectorXd b;
  std::vector<Vec3d> normal;
  std::vector<double> friction;
  int held = 0;
};

Vec3d at(const VectorXd& v, int i) { return {v[3 * i], v[3 * i + 1], v[3 * i + 2]}; }

/// Symmetric, positive definite and dense, as the compliance of an elastic body of random shape.
Case random_case(int k, double friction, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto number = [&] { return normal(random); };
  const MatrixXd a = MatrixXd::NullaryExpr(3 * k, 3 * k, number);
  Case out{a * a.transpose() / (3 * k) + 0.1 * MatrixXd::Identity(3 * k, 3 * k),
           VectorXd::NullaryExpr(3 * k, number)};
  for (int i = 0; i < k; i++) {
    out.normal.push_back(normalized(Vec3d{number(), number(), number()}));
    out.friction.push_back(friction);
  }
  return out;
}

/// Points of a half space under a sphere that penetrates by `depth` at its center and is dragged by `slide`.
Case sphere_case(int side, double friction, double depth, double slide) {
  const HalfSpace s{.side = side};
  const sfem::Patch patch = half_space_patch(s);
  const auto n = Eigen::Index(3 * patch.points.size());
  Case out{Eigen::Map<const MatrixXd>(patch.compliance.data(), n, n), VectorXd(n)};
  const double radius = 20 * s.spacing;
  const Vec3d center{0.2 * s.spacing, 0.1 * s.spacing, radius - depth};
  for (int i = 0; i < int(patch.points.size()); i++) {
    const Vec3d d = patch.points[std::size_t(i)].x - center, normal = normalized(d);
    const Vec3d apart = normal * (norm(d) - radius) - Vec3d{slide, 0, 0};
    for (int axis = 0; axis < 3; axis++) out.b[3 * i + axis] = apart[axis];
    out.normal.push_back(normal);
    out.friction.push_back(friction);
  }
  return out;
}

FrictionalContactProblem load(const Case& in) {
  const int k = int(in.normal.size());
  FrictionalContactProblem p = make_frictional_contact_problem(k);
  p.count = k;
  p.held = in.held;
  for (int j = 0; j < 3 * k; j++)
    for (int i = 0; i < 3 * k; i++) p.compliance[std::size_t(j * p.stride + i)] = in.c(i, j);
  std::copy_n(in.b.data(), 3 * k, p.separation.begin());
  p.normal = in.normal;
  p.friction = in.friction;
  return p;
}

VectorXd forces(const FrictionalContactProblem& p) {
  return Eigen::Map<const VectorXd>(p.force.data(), 3 * p.count);
}

/// Largest violation of any condition, relative to the largest force or separation.
double violation(const Case& in, const VectorXd& force) {
  const VectorXd c = in.b + in.c * force;
  double worst = 0;
  const double f0 = std::max(force.lpNorm<Eigen::Infinity>(), 1e-300), c0 = in.b.lpNorm<Eigen::Infinity>();
  for (int i = 0; i < int(in.normal.size()); i++) {
    const Vec3d f = at(force, i), s = at(c, i), n = in.normal[std::size_t(i)];
    if (i < in.held) {
      worst = std::max(worst, norm(s) / c0);
      continue;
    }
    const double mu = in.friction[std::size_t(i)], fn = dot(f, n), sn = dot(s, n);
    const Vec3d ft = f - fn * n, st = s - sn * n;
    worst = std::max({worst, -fn / f0, -sn / c0, std::abs(fn * sn) / (f0 * c0), (norm(ft) - mu * fn) / f0});
    if (fn < 1e-7 * f0) continue;
    // Slip opposes friction and vanishes inside the cone.
    const double inside = std::max(0.0, mu * fn - norm(ft)) / f0;
    worst =
        std::max({worst, inside * norm(st) / c0, norm(cross(ft, st)) / (f0 * c0), dot(ft, st) / (f0 * c0)});
  }
  return worst;
}

/// Reference: tries all active sets until one satisfies the conditions.
VectorXd frictionless_by_enumeration(const Case& in) {
  const int k = int(in.normal.size());
  MatrixXd n = MatrixXd::Zero(3 * k, k);
  for (int i = 0; i < k; i++)
    for (int axis = 0; axis < 3; axis++) n(3 * i + axis, i) = in.normal[std::size_t(i)][axis];
  const MatrixXd c = n.transpose() * in.c * n;
  const VectorXd b = n.transpose() * in.b;
  for (int set = 0; set < 1 << k; set++) {
    std::vector<int> touching;
    for (int i = 0; i < k; i++)
      if (set >> i & 1) touching.push_back(i);
    VectorXd force = VectorXd::Zero(k);
    if (!touching.empty()) {
      const MatrixXd c_touching = c(touching, touching);
      const VectorXd b_touching = b(touching), found = c_touching.llt().solve(-b_touching);
      force(touching) = found;
    }
    if (force.minCoeff() >= 0 && (b + c * force).minCoeff() >= -1e-12) return n * force;
  }
  ADD_FAILURE() << "no active set satisfies the conditions";
  return VectorXd::Zero(3 * k);
}

/// Reference: projected fixed-point iteration with a small step, slow and independent of the solver.
VectorXd by_fixed_point(const Case& in, double tolerance) {
  const int k = int(in.normal.size());
  const double step = 1 / in.c.norm();
  VectorXd force = VectorXd::Zero(3 * k);
  for (int iteration = 0; iteration < 3'000'000; iteration++) {
    const VectorXd c = in.b + in.c * force, before = force;
    for (int i = 0; i < k; i++) {
      const Vec3d n = in.normal[std::size_t(i)], s = at(c, i);
      const double mu = in.friction[std::size_t(i)];
      const double slip = norm(s - dot(s, n) * n);
      // De Saxcé's change of variable makes the law a projection on the cone.
      Vec3d f = at(force, i) - step * (s + mu * slip * n);
      const double fn = dot(f, n);
      const Vec3d ft = f - fn * n;
      if (mu * norm(ft) <= -fn)
        f = {};
      else if (norm(ft) > mu * fn) {
        const double on = (mu * norm(ft) + fn) / (1 + mu * mu);
        f = on * n + (mu * on / norm(ft)) * ft;
      }
      for (int axis = 0; axis < 3; axis++) force[3 * i + axis] = f[axis];
    }
    if ((force - before).norm() <= tolerance * force.norm()) break;
  }
  return force;
}

// Without friction, the forces equal those of the one active set that satisfies the conditions.
TEST(Coulomb, Frictionless_MatchesEnumeration) {
  std::mt19937 random(1);
  double worst = 0;
  for (int trial = 0; trial < 200; trial++) {
    const Case in = random_case(2 + trial % 9, 0, random);
    FrictionalContactProblem p = load(in);
    EXPECT_TRUE(solve(p, {.tolerance = 1e-9}).converged);
    const VectorXd exact = frictionless_by_enumeration(in);
    worst = std::max(worst, (forces(p) - exact).norm() / std::max(exact.norm(), 1e-3));
  }
  EXPECT_LT(worst, 1e-8);
  RecordProperty("worst", std::to_string(worst));
}

// A single site satisfies Coulomb's law for random loads and coefficients of friction.
TEST(Coulomb, OneSiteSatisfiesLaw) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  double worst = 0;
  int slips = 0;
  for (int trial = 0; trial < 20000; trial++) {
    Case in = random_case(1, std::array{0.0, 0.1, 0.5, 1.5}[std::size_t(trial % 4)], random);
    in.b *= std::pow(10, 2 * normal(random));
    FrictionalContactProblem p = load(in);
    solve(p);
    slips += p.state[0] == SiteState::kSlip;
    worst = std::max(worst, violation(in, forces(p)));
  }
  EXPECT_GT(slips, 1000);
  EXPECT_LT(worst, 1e-12);
}

// Up to 32 coupled sites satisfy Coulomb's law up to rounding.
TEST(Coulomb, ManySitesSatisfyLaw) {
  std::mt19937 random(3);
  double worst = 0;
  int unsolved = 0;
  for (int trial = 0; trial < 400; trial++) {
    const Case in = random_case(2 + trial % 31, 0.1 + 0.2 * (trial % 4), random);
    FrictionalContactProblem p = load(in);
    const FrictionalContactReport report = solve(p, {.tolerance = 1e-9});
    unsolved += !report.converged;
    if (report.converged) worst = std::max(worst, violation(in, forces(p)));
  }
  EXPECT_EQ(unsolved, 0);
  EXPECT_LT(worst, 1e-7);
}

// The forces on a dragged sphere equal those of an independent fixed-point iteration.
TEST(Coulomb, DraggedSphere_MatchesFixedPoint) {
  for (const double slide : {0.0, 1e-5, 1e-4, 1e-3}) {
    const Case in = sphere_case(5, 0.3, 4e-4, slide);
    FrictionalContactProblem p = load(in);
    EXPECT_TRUE(solve(p, {.tolerance = 1e-9}).converged);
    const VectorXd slow = by_fixed_point(in, 1e-13);
    EXPECT_LT(violation(in, forces(p)), 1e-7) << slide;
    EXPECT_LT((forces(p) - slow).norm() / slow.norm(), 1e-6) << slide;
  }
}

// A drag below the friction cone sticks; above it, the site slides with μ times the normal force.
TEST(Coulomb, SticksBelowConeSlidesAbove) {
  for (const double mu : {0.1, 0.4, 0.8}) {
    const HalfSpace s{.side = 1};
    const Mat3d d = half_space_response(s, 0, 0);
    const double depth = 1e-4, normal_force = depth / d.column[2].z;
    for (const double load_ratio : {0.99, 1.01}) {
      Case in{MatrixXd(3, 3), VectorXd(3), {{0, 0, -1}}, {mu}};
      for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) in.c(i, j) = d.column[j][i];
      in.b << -load_ratio * mu * normal_force * d.column[0].x, 0, depth;
      FrictionalContactProblem p = load(in);
      solve(p);
      EXPECT_EQ(p.state[0], load_ratio < 1 ? SiteState::kStick : SiteState::kSlip);
      EXPECT_NEAR(p.force[0], std::min(load_ratio, 1.0) * mu * normal_force, 1e-12 * normal_force);
      EXPECT_NEAR(p.force[2], -normal_force, 1e-12 * normal_force);
    }
  }
}

// Held sites have the forces of a direct solve with the capacitance matrix.
TEST(Coulomb, HeldSites_MatchCapacitanceMatrix) {
  std::mt19937 random(4);
  for (const int k : {1, 5, 30}) {
    Case in = random_case(k, 0.3, random);
    in.held = k;
    FrictionalContactProblem p = load(in);
    EXPECT_TRUE(solve(p, {.tolerance = 1e-9}).converged);
    const VectorXd exact = in.c.llt().solve(-in.b);
    EXPECT_LT((forces(p) - exact).norm() / exact.norm(), 1e-12);
  }
}

// Held and touching sites together satisfy their conditions.
TEST(Coulomb, HeldAndTouchingSitesSatisfyLaw) {
  std::mt19937 random(5);
  double worst = 0;
  for (int trial = 0; trial < 100; trial++) {
    Case in = random_case(4 + trial % 20, 0.3, random);
    in.held = 1 + trial % 3;
    FrictionalContactProblem p = load(in);
    EXPECT_TRUE(solve(p, {.tolerance = 1e-9}).converged);
    worst = std::max(worst, violation(in, forces(p)));
  }
  EXPECT_LT(worst, 1e-7);
}

// Two held sites at the same position have finite forces.
TEST(Coulomb, CoincidentHeldSitesStayFinite) {
  std::mt19937 random(6);
  Case in = random_case(3, 0.3, random);
  in.held = 2;
  in.c.middleRows(3, 3) = in.c.middleRows(0, 3).eval();
  in.c.middleCols(3, 3) = in.c.middleCols(0, 3).eval();
  in.b.segment(3, 3) = in.b.segment(0, 3).eval();
  FrictionalContactProblem p = load(in);
  solve(p);
  EXPECT_TRUE(forces(p).allFinite());
  EXPECT_LT((in.b + in.c * forces(p)).head(6).norm(), 1e-9);
}

// Separated sites have no force, after one sweep.
TEST(Coulomb, SeparatedSitesHaveNoForce) {
  std::mt19937 random(7);
  Case in = random_case(6, 0.5, random);
  for (int i = 0; i < 6; i++)
    for (int axis = 0; axis < 3; axis++) in.b[3 * i + axis] = in.normal[std::size_t(i)][axis];
  FrictionalContactProblem p = load(in);
  EXPECT_EQ(solve(p).sweeps, 1);
  EXPECT_EQ(forces(p).norm(), 0);
}

// With Newton steps, a warm start converges within 12 sweeps.
TEST(Coulomb, NewtonStepsBoundWarmSweeps) {
  for (const int side : {3, 4, 5, 6}) {
    const Case in = sphere_case(side, 0.3, 1e-3, 2e-4);
    FrictionalContactProblem p = load(in);
    const FrictionalContactReport cold = solve(p, {.tolerance = 1e-10});
    const VectorXd guess = 1.01 * forces(p);
    p = load(in);
    std::copy_n(guess.data(), guess.size(), p.force.begin());
    const FrictionalContactReport warm = solve(p, {.tolerance = 1e-10});
    EXPECT_TRUE(cold.converged && warm.converged) << side;
    EXPECT_LE(warm.sweeps, 12) << side;
    std::printf("%d sites: cold %d sweeps, %d Newton steps; warm %d, %d\n", side * side, cold.sweeps,
                cold.newton_steps, warm.sweeps, warm.newton_steps);
  }
}

/// Points of a half space under two balls at random positions, whose tools slip by `slide` each.
Case two_tools_case(const sfem::Patch& patch, std::mt19937& random, double friction,
                    const std::array<Vec3d, 2>& center, const std::array<Vec3d, 2>& slide) {
  constexpr double radius = 6e-3;
  std::vector<int> near;
  Case out{};
  std::vector<Vec3d> apart;
  for (int i = 0; i < int(patch.points.size()); i++)
    for (std::size_t tool = 0; tool < 2; tool++) {
      const Vec3d d = patch.points[std::size_t(i)].x - center[tool];
      if (norm(d) > radius + 1e-5 || near.size() == 32) continue;
      near.push_back(i), out.normal.push_back(normalized(d));
      apart.push_back(out.normal.back() * (norm(d) - radius) - slide[tool]);
      break;
    }
  const auto k = Eigen::Index(near.size()), n = Eigen::Index(3 * patch.points.size());
  const Eigen::Map<const MatrixXd> all(patch.compliance.data(), n, n);
  out.c.resize(3 * k, 3 * k), out.b.resize(3 * k);
  std::uniform_real_distribution<double> factor(0.5, 1.5);
  for (Eigen::Index j = 0; j < k; j++) {
    for (Eigen::Index i = 0; i < k; i++)
      out.c.block<3, 3>(3 * i, 3 * j) = all.block<3, 3>(3 * near[std::size_t(i)], 3 * near[std::size_t(j)]);
    for (int axis = 0; axis < 3; axis++) out.b[3 * j + axis] = apart[std::size_t(j)][axis];
    out.friction.push_back(friction * factor(random));
  }
  return out;
}

// At random poses of two tools with random friction, the forces from those of the last tick equal the forces
// from nothing to 1e-5.
TEST(Coulomb, WarmStart_MatchesSolutionFromNothing) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&](double size) {
    return Vec3d{number(random), number(random), number(random)} * size;
  };
  const sfem::Patch patch = half_space_patch({.side = 11});
  double worst = 0;
  int compared = 0, mixed = 0;
  for (int path = 0; path < 40; path++) {
    const double friction = 0.2 * (path % 4);
    std::array<Vec3d, 2> center{Vec3d{-2.5e-3, 0, 5.3e-3} + vector(4e-4),
                                Vec3d{2.5e-3, 0, 5.4e-3} + vector(4e-4)};
    VectorXd last;
    for (int tick = 0; tick < 6; tick++) {
      const std::array<Vec3d, 2> step{vector(1e-4), vector(1e-4)};
      std::mt19937 same(static_cast<unsigned>(path));
      const Case in = two_tools_case(patch, same, friction, center, step);
      FrictionalContactProblem cold = load(in), warm = load(in);
      if (last.size() == in.b.size()) std::copy_n(last.data(), last.size(), warm.force.begin());
      EXPECT_TRUE(solve(cold).converged) << path;
      EXPECT_TRUE(solve(warm).converged) << path;
      compared += last.size() == in.b.size();
      const auto count = [&](SiteState state) {
        return std::count(warm.state.begin(), warm.state.end(), state);
      };
      mixed += count(SiteState::kStick) > 2 && count(SiteState::kSlip) > 2;
      if (const double size = forces(cold).norm(); size > 0)
        worst = std::max(worst, (forces(warm) - forces(cold)).norm() / size);
      last = forces(warm);
      for (std::size_t tool = 0; tool < 2; tool++) center[tool] += step[tool];
    }
  }
  EXPECT_LT(worst, 1e-5);
  EXPECT_GT(compared, 100);
  EXPECT_GT(mixed, 20);
  std::printf("worst difference %.1e, %d of 240 from the last tick, %d mixed\n", worst, compared, mixed);
}

// Newton steps converge at once where some sites stick and others barely slip.
TEST(Coulomb, MixedStickAndSlip_FewNewtonSteps) {
  int mixed = 0;
  for (int side = 4; side <= 6; side++)
    for (double slide = 2e-5; slide < 1e-3; slide *= 1.1) {
      const Case in = sphere_case(side, 0.3, 1e-3, slide);
      FrictionalContactProblem p = load(in);
      const FrictionalContactReport report = solve(p, {.tolerance = 1e-9});
      const auto count = [&](SiteState state) { return std::count(p.state.begin(), p.state.end(), state); };
      mixed += count(SiteState::kStick) > 3 && count(SiteState::kSlip) > 3;
      EXPECT_TRUE(report.converged) << side << ' ' << slide;
      EXPECT_LE(report.sweeps, 8) << side << ' ' << slide;
      EXPECT_LE(report.newton_steps, 5) << side << ' ' << slide;
    }
  EXPECT_GT(mixed, 10);
}

}  // namespace
}  // namespace turgor::contact

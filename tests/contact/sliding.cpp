// Continuity of the force: a ball slides over triangles larger than itself, and wide contacts exceed the
// capacity of sites.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "half_space.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor::contact {
namespace {

constexpr double kTick = 1e-3;

/// 100 × 100 × 40 mm of irregular tetrahedra, and the patch in its middle.
sfem::Patch irregular_patch(int cells, unsigned seed, bool quadratic, int refinement) {
  SolidMesh mesh = hex_block({0.1, 0.1, 0.04}, {cells, cells, 4});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.02 / cells, 0.02 / cells);
  for (Vec3d& x : mesh.vertices)
    if (std::min(x.x, x.y) > 1e-9 && std::max(x.x, x.y) < 0.1 - 1e-9)
      x += Vec3d{shift(random), shift(random), x.z > 1e-9 && x.z < 0.04 - 1e-9 ? shift(random) : 0};
  sfem::Body body{.mesh = tetrahedralize(mesh), .materials = {{3e3, 0.45}}};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < 1e-9);
  if (quadratic) body = sfem::with_middles(std::move(body));
  sfem::Model model =
      sfem::build(Exec(1), std::move(body), {.formulation = sfem::Formulation::kAveraged, .touch_depth = 0.1})
          .value();
  EXPECT_TRUE(sfem::compute_green(Exec(1), model, std::size_t(1) << 30));
  const std::vector<Vec3d> touch{{0.05, 0.05, 0.04}};
  return sfem::build_patch(model, sfem::patch_elements(model, touch, 0.022), refinement, touch).value();
}

struct Slide {
  double radius, depth, friction, angle;  // [m] [m] [1] [rad]
  int capacity = 32;
};

/// Largest change of the force between two ticks at 30 mm/s, relative to the mean force.
double largest_step(const sfem::Patch& patch, const Slide& slide) {
  constexpr double kHalfLength = 0.009, kSpeed = 0.03;
  constexpr int kPress = 300, kTicks = int(2 * kHalfLength / kSpeed / kTick);
  const Vec3d along{std::cos(slide.angle), std::sin(slide.angle), 0}, middle{0.05, 0.05, 0.04 + slide.radius};
  TouchState state = make_touch_state(patch, 1, {.capacity = slide.capacity});
  const std::vector<Tool> tools{{Sphere{slide.radius}, slide.friction}};
  std::vector<ToolPose> poses(1);
  std::vector<ToolForce> forces(1);
  double largest = 0, mean = 0;
  Vec3d before;
  for (int i = -kPress; i <= kTicks; i++) {
    const double depth = slide.depth * std::min(1.0, double(i + kPress) / (0.8 * kPress));
    const double travel = kSpeed * kTick * std::max(0, i) - kHalfLength;
    poses[0].pose.position = middle + along * travel - Vec3d{0, 0, depth};
    solve_touch_tick(patch, state, tools, poses, kTick, forces);
    if (i > 0) largest = std::max(largest, norm(forces[0].force - before));
    if (i > 0) mean += norm(forces[0].force) / kTicks;
    before = forces[0].force;
  }
  EXPECT_GT(mean, 0.01) << "N";
  return largest / mean;
}

// The force does not jump while a ball slides over triangles larger than itself.
TEST(Sliding, LargeTriangles_NoForceJumps) {
  for (const bool quadratic : {false, true})
    for (const auto& [cells, seed] : {std::pair{10, 3u}, {8, 5u}}) {
      const sfem::Patch patch = irregular_patch(cells, seed, quadratic, quadratic ? 1 : 2);
      for (const double angle : {0.0, 0.6})
        for (const double friction : {0.0, 0.2}) {
          const double step = largest_step(patch, {0.004, 0.002, friction, angle});
          std::printf("%s, %d cells, %.1f rad, friction %.1f: steps of at most %.2f %% of the force\n",
                      quadratic ? "quadratic" : "linear", cells, angle, friction, 100 * step);
          EXPECT_LT(step, 0.02) << cells << " cells, " << angle << " rad, friction " << friction;
        }
    }
}

// The force does not jump where triangles are about as large as the tool.
TEST(Sliding, TrianglesOfToolSize_NoForceJumps) {
  const sfem::Patch patch = irregular_patch(10, 3, false, 2);
  for (const double angle : {0.0, 0.6}) EXPECT_LT(largest_step(patch, {0.007, 0.003, 0, angle}), 0.02);
}

// A contact with more points than the capacity does not swap points every tick.
TEST(Sliding, ExceededCapacity_NoForceJumps) {
  const sfem::Patch patch = irregular_patch(16, 3, false, 2);
  for (const int capacity : {24, 32, 40}) {
    const double step = largest_step(patch, {0.015, 0.006, 0.1, 0.6, capacity});
    EXPECT_LT(step, 0.02) << capacity;
  }
}

/// Statistics of a ball that is shaken at random in a grid of points.
struct Shaken {
  int most_sweeps = 0, most_newton = 0, unsolved = 0, most_contacts = 0;
  double beyond_cone = 0;  // largest friction above the Coulomb limit, relative to the largest force
};
Shaken shake(double friction, double reach, unsigned seed) {
  const HalfSpace space{.side = 17, .spacing = 10e-3 / 16};
  sfem::Patch patch = half_space_patch(space);
  sfem::add_levels(patch);
  TouchState state = make_touch_state(patch, 1, {});
  const std::vector<Tool> tools{{Sphere{5e-3}, friction}};
  std::vector<ToolPose> poses(1);
  std::vector<ToolForce> forces(1);
  std::mt19937 random(seed);
  std::normal_distribution<double> step(0, reach);
  Vec3d offset;
  Shaken result;
  for (int i = 0; i < 1500; i++) {
    offset = offset * 0.9 + Vec3d{step(random), step(random), 0.5 * step(random)};
    poses[0].pose.position = Vec3d{0, 0, 5e-3 - 1.6e-3} + offset;
    solve_touch_tick(patch, state, tools, poses, kTick, forces);
    result.most_sweeps = std::max(result.most_sweeps, state.solution.sweeps);
    result.most_newton = std::max(result.most_newton, state.solution.newton_steps);
    result.unsolved += !state.solution.converged;
    result.most_contacts = std::max(result.most_contacts, forces[0].contacts);
    double largest = 1e-12;
    for (const Site& site : state.sites) largest = std::max(largest, norm(site.force));
    for (const Site& site : state.sites) {
      const double push = dot(site.force, site.normal), rub = norm(site.force - site.normal * push);
      result.beyond_cone = std::max({result.beyond_cone, (rub - friction * std::max(push, 0.0)) / largest});
    }
  }
  return result;
}

// Many contacts are solved in a bounded number of iterations and stay within the friction cone.
TEST(Sliding, ManyContacts_BoundedIterations) {
  for (const auto& [friction, reach] : {std::pair{0.3, 1e-4}, {1.5, 3e-4}, {3.0, 1e-3}}) {
    const Shaken jam = shake(friction, reach, 1);
    std::printf("friction %.1f: up to %d contacts, %d sweeps, %d Newton steps, %d ticks unsolved\n", friction,
                jam.most_contacts, jam.most_sweeps, jam.most_newton, jam.unsolved);
    EXPECT_GT(jam.most_contacts, 15);
    EXPECT_LE(jam.most_sweeps, 120);
    EXPECT_LE(jam.most_newton, 6);
    EXPECT_LT(jam.unsolved, 15) << "of 1500";
    EXPECT_LT(jam.beyond_cone, 1e-6);
  }
}

}  // namespace
}  // namespace turgor::contact

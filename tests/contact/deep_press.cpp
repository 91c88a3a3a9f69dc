// Presses as deep as the radius of a ball and a nodule below the surface, against an independent
// axisymmetric program.
#include <array>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/contact/layer_model.hpp"
#include "tests/contact/pressed_lattice.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor::contact {
namespace {

constexpr double kStep = 0.002, kBall = 0.008, kSmallBall = 0.006;
constexpr Int3 kSize{33, 33, 13};
constexpr double kPoisson = 0.45;

Pressed solid_block(int sweeps, const std::function<double(Vec3d)>& young = {}) {
  Pressed block(kSize, kStep, sweeps, {Sphere{kBall}, 0}, middle(kSize, kStep, 1), false,
                {.law = lattice::TissueLaw::kSolid, .poisson = kPoisson}, young);
  block.at[0].pose.position.z = block.top + kBall;
  return block;
}

/// Layer as thick as the block, wide enough that its rim does not matter.
PressedLayer thick_layer(Nodule nodule = {}) {
  return {.thickness = 0.0249,
          .width = 0.032,
          .ball = kBall,
          .young = kYoung,
          .poisson = kPoisson,
          .law = PressedLaw::kStable,
          .nodule = nodule,
          .across = 16,
          .down = 10,
          .step = 2e-4,
          .softness = 2e-5};
}
PressedLayer linear_layer() {
  return {.thickness = 0.02,
          .width = 0.05,
          .ball = kSmallBall,
          .young = kYoung,
          .poisson = kPoisson,
          .law = PressedLaw::kLinear,
          .across = 18,
          .down = 10,
          .step = 2e-4,
          .softness = 2e-5};
}
constexpr Nodule kNodule{.depth = 0.0105, .radius = 0.0055, .young = 10 * kYoung};

/// Force of the independent program at a depth, as a share of the ball's radius [N].
struct KnownForce {
  double share, force;
};
constexpr std::array<KnownForce, 2> kFiniteStrain{{{0.25, 0.05969}, {0.75, 0.32039}}};
constexpr std::array<KnownForce, 1> kWithNodule{{{0.25, 0.07706}}};
constexpr std::array<KnownForce, 2> kLinear{{{0.5, 0.08720}, {1, 0.16383}}};

// The known forces, computed again: takes most of a minute.
TEST(DeepPress, DISABLED_KnownForcesAreThoseOfProgram) {
  AxisymmetricPress strong(thick_layer()), nodule(thick_layer(kNodule)), linear(linear_layer());
  for (const auto& [share, force] : kFiniteStrain)
    EXPECT_NEAR(strong.force(share * kBall), force, 1e-4 * force);
  for (const auto& [share, force] : kWithNodule)
    EXPECT_NEAR(nodule.force(share * kBall), force, 1e-4 * force);
  for (const auto& [share, force] : kLinear)
    EXPECT_NEAR(linear.force(share * kSmallBall), force, 1e-4 * force);
}

// A ball pressed to three quarters of its radius has the force of finite strain in the same material. The
// force on the held nodes is that of the ball.
TEST(DeepPress, LatticeMatchesFiniteStrain) {
  Pressed block = solid_block(20);
  for (const auto& [share, expected] : kFiniteStrain) {
    const double depth = share * kBall;
    block.move_to(Exec(2), middle(kSize, kStep, block.top + kBall - depth), 12);
    block.move_to(Exec(2), block.at[0].pose.position, 20);
    const double found = block.forces[0].force.z, held = reaction(block);
    std::printf(
        "%.2f radii: %.4f N, independent %.4f N (%+.1f %%), held nodes %.4f N (%+.2f %%), %.3f mm inside\n",
        share, found, expected, 100 * (found / expected - 1), held, 100 * (std::abs(held) / found - 1),
        1e3 * block.forces[0].largest_penetration);
    EXPECT_NEAR(found, expected, 0.1 * expected) << share << " radii";
    EXPECT_NEAR(std::abs(held), found, 0.01 * found) << share << " radii";
  }
}

// A nodule below the surface stiffens a press as much as in the independent program.
TEST(DeepPress, LatticeFeelsNodule) {
  const double top = thick_layer().thickness;
  Pressed plain = solid_block(20);
  Pressed block = solid_block(20, [&](Vec3d x) {
    const Vec3d away = x - middle(kSize, kStep, top - kNodule.depth);
    return norm(away) < kNodule.radius ? kNodule.young : kYoung;
  });
  for (std::size_t n = 0; n < kWithNodule.size(); n++) {
    const double depth = kWithNodule[n].share * kBall,
                 expected = kWithNodule[n].force / kFiniteStrain[n].force;
    for (Pressed* p : {&plain, &block}) {
      p->move_to(Exec(2), middle(kSize, kStep, p->top + kBall - depth), 12);
      p->move_to(Exec(2), p->at[0].pose.position, 20);
    }
    const double found = block.forces[0].force.z / plain.forces[0].force.z;
    std::printf("%.0f mm: %.3f times the force without the nodule, independent %.3f\n", 1e3 * depth, found,
                expected);
    EXPECT_NEAR(found, expected, 0.1 * expected);
  }
}

// Linear elements have the force of linear elasticity down to the radius of the ball.
TEST(DeepPress, LinearElementsMatchLinearProgram) {
  const PressedLayer layer = linear_layer();
  sfem::Model model = layer_model(layer, 5e-3, 3);
  const std::vector<Vec3d> touch{{0, 0, 0}};
  const std::vector<int> elements = sfem::patch_elements(model, touch, 0.014);
  std::vector<int> vertices;
  for (const int e : elements)
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  sort_unique(vertices);
  sfem::fetch_columns(Exec(2), model, vertices);
  const sfem::Patch patch = sfem::build_patch(model, elements, 3, touch).value();
  TouchState state = make_touch_state(patch, 1, {.capacity = 160});
  const std::vector<Tool> tools{{Sphere{kSmallBall}, 0}};
  std::vector<ToolForce> forces(1);
  double before = 0;
  for (const auto& [share, expected] : kLinear) {
    const double depth = share * kSmallBall;
    for (int t = 1; t <= 60; t++) {
      const double now = before + (depth - before) * std::min(1.0, t / 40.0);
      const std::vector<ToolPose> poses{{{{0, 0, kSmallBall - now}, {}}, false}};
      solve_touch_tick(patch, state, tools, poses, 1e-3, forces);
    }
    before = depth;
    const double found = forces[0].force.z;
    std::printf("%.2f radii: %.4f N, independent %.4f N (%+.1f %%), %d contacts%s\n", share, found, expected,
                100 * (found / expected - 1), forces[0].contacts,
                forces[0].beyond_patch ? ", beyond patch" : "");
    EXPECT_NEAR(found, expected, 0.05 * expected) << share << " radii";
  }
}

}  // namespace
}  // namespace turgor::contact

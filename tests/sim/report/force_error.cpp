#include "turgor/sim/report/force_error.hpp"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/block_scene.hpp"
#include "tests/sim/sfem_scene_text.hpp"

namespace turgor {
namespace {

constexpr double kSpacing = 0.004, kYoung = 5400, kPoisson = 0.45;

/// 40 mm of fat on bone, pressed from the front by a ball, beside a node by these distances.
World pressed_fat(double radius, double depth, double beside) {
  const std::filesystem::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const Result<Scene> scene = parse_scene(
      fmt::format("[world]\nduration = 0.5\ngravity = [0, 0, 0]\n"
                  "[body.fat]\nmodel = \"lattice\"\nct = \"{}\"\nblock = 1\nfixed = \"bone\"\nskin = false\n"
                  "tissue = {{ young = {}, poisson = {} }}\nsolver = {{ sweeps = 10, damping = 8 }}\n"
                  "[tool.ball]\nbody = \"fat\"\nshape = {{ sphere = {} }}\nfriction = 0\n"
                  "press = {{ at = [{}, -0.022, {}], depth = {}, start = 0, duration = 0.25, hold = 0.3 }}\n",
                  (folder / "block.nii").string(), kYoung, kPoisson, radius, 0.002 + beside, 0.002 + beside,
                  depth),
      "s.toml");
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  World world = test::sfem_world(Exec(2), *scene);
  for (int frame = 0; frame < 30; frame++) EXPECT_TRUE(step(Exec(2), world));
  return world;
}

/// Force of a rigid ball on a bonded layer [N]: Hertz's 4/3 E/(1 − ν²) √R d^(3/2) times the series in
/// χ = √(R d)/H of Dimitriadis et al. 2002, up to χ².
double layer_force(double radius, double depth) {
  constexpr double kLayer = 0.04, kNu = kPoisson;  // thickness [m]
  const double chi = std::sqrt(radius * depth) / kLayer;
  const double slope =
      2 / std::numbers::pi * (1.2876 - 1.4678 * kNu + 1.3442 * kNu * kNu) / (1 - kNu);  // −2 α₀/π
  const double hertz = 4.0 / 3 * kYoung / (1 - kNu * kNu) * std::sqrt(radius) * std::pow(depth, 1.5);
  return hertz * (1 + slope * chi + slope * slope * chi * chi);
}

// The expected error of a lattice covers the distance to a closed form on a node and between nodes.
TEST(LatticeForceError, CoversPressOnAndBetweenNodes) {
  for (const double beside : {0.0, 0.25 * kSpacing, 0.5 * kSpacing}) {
    constexpr double kRadius = 0.01, kDepth = 0.0015;
    const World world = pressed_fat(kRadius, kDepth, beside);
    const TouchingTool& tool = world.tools[0];
    const std::optional<double> expected = expected_force_error(world, tool);
    ASSERT_TRUE(expected);
    EXPECT_NEAR(*expected, lattice_force_error(kSpacing, std::sqrt(kRadius * kDepth)), 0.02);
    const double found = norm(tool.samples.back().force) / layer_force(kRadius, kDepth);
    std::printf("%.2f spacings beside a node: %.3f of the closed form, expected error %.2f\n",
                beside / kSpacing, found, *expected);
    EXPECT_LT(std::abs(found - 1), *expected) << beside;
  }
}

// A contact smaller than the spacing causes a warning, and the advised spacing does not.
TEST(LatticeForceError, SmallContactWarns) {
  const World world = pressed_fat(0.004, 0.001, 0);
  const std::vector<std::string> warnings = force_error_warnings(world);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(
      warnings[0].starts_with("ball: the expected force error is more than 100 %: the lattice's "
                              "spacing is 4 mm, for a contact radius of 2 mm"))
      << warnings[0];
  const std::string advice = "a spacing of ";
  const std::size_t at = warnings[0].find(advice);
  ASSERT_NE(at, std::string::npos) << warnings[0];
  const double advised = 1e-3 * std::stod(warnings[0].substr(at + advice.size()));
  EXPECT_NEAR(lattice_force_error(advised, 0.002), 0.2, 0.02);
}

}  // namespace
}  // namespace turgor

// Parameters are found again from forces of closed forms, and from a finer mesh.
#include "turgor/sim/identify.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/solid_files.hpp"

namespace turgor {
namespace {

MeasuredForce rows(const std::function<double(double)>& force, double last, int count, double noise = 0) {
  std::mt19937 random(11);
  std::normal_distribution<double> error(0, noise);
  MeasuredForce measured;
  for (int i = 1; i <= count; i++) {
    const double at = last * i / count;
    measured.at.push_back(at), measured.force.push_back(force(at) + error(random));
  }
  return measured;
}

/// F = E (x + b x³): two parameters.
ForceModel stiffening_model(const MeasuredForce& measured) {
  return [&measured](const std::vector<double>& p) -> Result<std::vector<double>> {
    std::vector<double> force;
    for (const double x : measured.at) force.push_back(p[0] * (x + p[1] * x * x * x));
    return force;
  };
}

// From wrong start values, exact data give the parameters; noisy data give intervals that hold them.
TEST(Identify, FindsParametersOfClosedForm) {
  const auto force = [](double x) { return 41.0 * (x + 0.7 * x * x * x); };
  const MeasuredForce exact = rows(force, 1.4, 25);
  const Identified found =
      fit_parameters(stiffening_model(exact), {exact}, {{"young", 5}, {"stiffening", 6}}).value();
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.parameters[0].value, 41, 1e-3 * 41);
  EXPECT_NEAR(found.parameters[1].value, 0.7, 1e-3);
  EXPECT_LT(found.residual, 1e-4);
  EXPECT_GT(found.start_residual, 0.3);

  int inside = 0;
  for (int seed = 0; seed < 20; seed++) {
    MeasuredForce noisy = exact;
    std::mt19937 random{unsigned(seed)};
    std::normal_distribution<double> error(0, 1.5);
    for (double& f : noisy.force) f += error(random);
    const Identified fit =
        fit_parameters(stiffening_model(noisy), {noisy}, {{"young", 20}, {"stiffening", 2}}).value();
    inside += fit.parameters[0].low < 41 && 41 < fit.parameters[0].high;
    EXPECT_TRUE(fit.parameters[0].is_observable);
  }
  EXPECT_GE(inside, 17) << "95 % intervals";
}

// Parameters that only act as a product, and one that does not act, are named.
TEST(Identify, ParametersThatDataDoNotShow_AreNamed) {
  const MeasuredForce measured = rows([](double x) { return 3 * x; }, 1, 12, 0.01);
  const ForceModel product = [&](const std::vector<double>& p) -> Result<std::vector<double>> {
    std::vector<double> force;
    for (const double x : measured.at) force.push_back(p[0] * p[1] * x);
    return force;
  };
  const Identified found = fit_parameters(product, {measured}, {{"a", 1}, {"b", 1}}).value();
  EXPECT_FALSE(found.parameters[0].is_observable);
  EXPECT_FALSE(found.notes.empty());
}

// Too few rows and start values that are not positive are refused with a sentence.
TEST(Identify, WrongInputIsRefused) {
  const MeasuredForce few = rows([](double x) { return x; }, 1, 2);
  const Result<Identified> found = fit_parameters(stiffening_model(few), {few}, {{"a", 1}, {"b", 1}});
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("at least 4 rows"), std::string::npos);
  const MeasuredForce enough = rows([](double x) { return x; }, 1, 9);
  EXPECT_FALSE(fit_parameters(stiffening_model(enough), {enough}, {{"a", 0}, {"b", 1}}));
}

/// A viscous block that a ball presses and holds.
std::string block_scene(const std::string& count, const std::string& material) {
  return "[world]\nduration = 0.2\n[body.pad]\nmodel = \"sfem\"\nblock = { size = [0.04, 0.04, 0.02], count "
         "= " +
         count + " }\nfixed = \"bottom\"\npoisson = 0.4\npatch = { radius = 0.011, refinement = 2 }\n" +
         material +
         "[tool.ball]\nbody = \"pad\"\nshape = { sphere = 0.016 }\nfriction = 0\n"
         "press = { at_fraction = [0.5, 0.5, 1], depth = 0.0015, start = 0, duration = 0.05, hold = 0.15 }\n";
}

// Young's modulus and a Prony pair are found again from a run of a finer mesh.
TEST(Identify, FindsTissueOfFinerMesh) {
  const auto folder = test::fresh_folder();
  const Exec exec(2);
  // data
  const Scene truth = parse_scene(block_scene("[10, 10, 5]",
                                              "cache = false\nyoung = 5200\n"
                                              "viscosity = { pairs = [[0.35, 0.06]] }\n"),
                                  folder / "truth.toml", {})
                          .value();
  World world = test::sfem_world(exec, truth);
  for (int frame = 0; frame < frame_count(truth); frame++) ASSERT_TRUE(step(exec, world));
  MeasuredForce measured{.by_time = true};
  for (const ForceSample& s : world.tools[0].samples)
    if (s.time > 0.02 && std::lround(s.time * 1000) % 5 == 0)
      measured.at.push_back(s.time), measured.force.push_back(norm(s.force));
  // fit
  ASSERT_TRUE(write_file(folder / "fit.toml", block_scene("[8, 8, 4]", "young = 3000\n")));
  const IdentifyInput input{.scene = folder / "fit.toml",
                            .parameters = {{"body.pad.young", 3000},
                                           {"body.pad.viscosity.pairs[0][0]", 0.15},
                                           {"body.pad.viscosity.pairs[0][1]", 0.15}}};
  const Identified found = identify(exec, input, {measured}).value();
  EXPECT_NEAR(found.parameters[0].value, 5200, 0.05 * 5200);
  EXPECT_NEAR(found.parameters[1].value, 0.35, 0.05 * 0.35);
  EXPECT_NEAR(found.parameters[2].value, 0.06, 0.1 * 0.06);
  EXPECT_LT(found.residual, 0.03);
  for (const FittedParameter& p : found.parameters) EXPECT_TRUE(p.is_observable) << p.key;
  std::printf("E %.0f Pa, g %.3f, tau %.4f s; residual %.2f %%, %d runs\n", found.parameters[0].value,
              found.parameters[1].value, found.parameters[2].value, 100 * found.residual, found.runs);
  // a key that does not exist
  IdentifyInput wrong = input;
  wrong.parameters = {{"body.pad.yuong", 3000}};
  const Result<Identified> refused = identify(exec, wrong, {measured});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("yuong"), std::string::npos);
}

/// Moduli of skin, fat and muscle [Pa].
using Moduli = std::array<double, 3>;

/// A slab of skin, fat (3 mm each) and muscle (6 mm) in the mesh slab.msh. A narrow ball presses it, then a
/// wide one.
std::string slab_scene(const Moduli& young) {
  return fmt::format(
      "[world]\nduration = 0.42\n[body.slab]\nmodel = \"sfem\"\nmesh = \"slab.msh\"\nfixed = \"bottom\"\n"
      "cache = false\nyoung = {}\npoisson = 0.4\npatch = false\n"
      "inside.fat = {{ label = 2, young = {} }}\ninside.skin = {{ label = 3, young = {} }}\n"
      "[tool.narrow]\nbody = \"slab\"\nshape = {{ sphere = 0.005 }}\nfriction = 0\n"
      "press = {{ at_fraction = [0.5, 0.5, 1], depth = 0.0015, start = 0, duration = 0.2, hold = 0 }}\n"
      "[tool.wide]\nbody = \"slab\"\nshape = {{ sphere = 0.02 }}\nfriction = 0\n"
      "press = {{ at_fraction = [0.5, 0.5, 1], depth = 0.003, start = 0.21, duration = 0.2, hold = 0 }}\n",
      young[2], young[1], young[0]);
}
SolidMesh slab_mesh() {
  SolidMesh mesh = hex_block({0.042, 0.042, 0.012}, {14, 14, 4});
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const double height = centroid(mesh, e).z;
    mesh.regions.push_back(height > 0.009 ? 3 : height > 0.006 ? 2 : 1);
  }
  return mesh;
}

// The moduli of three layers are found within a tenth from the forces of two probes of different size with an
// error of 1 %. The forces are those of every tick.
TEST(Identify, TwoProbesShowThreeLayers) {
  const auto folder = test::fresh_folder();
  const Exec exec(2);
  ASSERT_TRUE(write_msh(folder / "slab.msh", slab_mesh()));
  // forces with errors
  const Moduli truth{4e4, 4e3, 1.2e4};
  const Scene scene = parse_scene(slab_scene(truth), folder / "slab.toml", {}).value();
  World world = test::sfem_world(exec, scene);
  for (int frame = 0; frame < frame_count(scene); frame++) ASSERT_TRUE(step(exec, world));
  std::vector<MeasuredForce> tables;
  std::mt19937 random(5);
  std::normal_distribution<double> error(0, 0.01);
  for (const TouchingTool& tool : world.tools) {
    MeasuredForce table{.tool = tool.name};
    for (const ForceSample& s : tool.samples) {
      if (s.depth < 3e-4 || (!table.at.empty() && s.depth <= table.at.back())) continue;
      table.at.push_back(s.depth), table.force.push_back(norm(s.force) * (1 + error(random)));
    }
    ASSERT_GE(table.at.size(), 60u);
    tables.push_back(table);
  }
  // fit
  const IdentifyInput input{.scene = folder / "fit.toml",
                            .text = slab_scene({1e4, 1e4, 1e4}),
                            .parameters = {{"body.slab.inside.skin.young", 1e4},
                                           {"body.slab.inside.fat.young", 1e4},
                                           {"body.slab.young", 1e4}}};
  const Identified both = identify(exec, input, tables).value();
  EXPECT_EQ(both.residuals.size(), 2u);
  for (std::size_t p = 0; p < 3; p++) {
    const FittedParameter& found = both.parameters[p];
    EXPECT_NEAR(found.value / truth[p], 1, 0.1) << found.key;
    EXPECT_TRUE(found.is_observable) << found.key;
    std::printf("%s %.0f (%.0f to %.0f)\n", found.key.c_str(), found.value, found.low, found.high);
  }
  std::printf("residual %.2f %%, %d runs\n", 100 * both.residual, both.runs);
}

/// Forces of a tool over its depth, with relative errors of this size.
MeasuredForce noisy_table(const TouchingTool& tool, double noise) {
  MeasuredForce table{.tool = tool.name};
  std::mt19937 random(7);
  std::normal_distribution<double> error(0, noise);
  for (const ForceSample& s : tool.samples) {
    if (s.depth < 3e-4 || (!table.at.empty() && s.depth <= table.at.back())) continue;
    table.at.push_back(s.depth), table.force.push_back(norm(s.force) * (1 + error(random)));
  }
  return table;
}

// One press over a stiff region shows the modulus of its label within 15 %, and that of the tissue around it,
// from wrong start values and forces with an error of 1 %. The moduli are those of two silicones: Ecoflex
// 00-10 with as much thinner and with a quarter of it. A press beside the region hardly shows it, and the fit
// says so.
TEST(Identify, OnePressShowsLabelInSilicone) {
  const auto folder = test::fresh_folder();
  const Exec exec(2);
  SolidMesh mesh = hex_block({0.03, 0.03, 0.012}, {10, 10, 4});
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const Vec3d at = centroid(mesh, e) - Vec3d{0.015, 0.015, 0.006};
    mesh.regions.push_back(std::max({std::abs(at.x), std::abs(at.y), 2 * std::abs(at.z)}) < 0.006 ? 2 : 1);
  }
  ASSERT_TRUE(write_msh(folder / "pad.msh", mesh));
  constexpr double kSoft = 5420, kStiff = 27390;
  const auto text = [](double soft, double stiff, double across) {
    return fmt::format(
        "[world]\nduration = 0.22\n[body.pad]\nmodel = \"sfem\"\nmesh = \"pad.msh\"\nfixed = \"bottom\"\n"
        "cache = false\nyoung = {}\npoisson = 0.45\npatch = false\ninside.nodule = {{ label = 2, young = {} "
        "}}\n"
        "[tool.ball]\nbody = \"pad\"\nshape = {{ sphere = 0.006 }}\nfriction = 0\n"
        "press = {{ at_fraction = [{}, 0.5, 1], depth = 0.0015, start = 0, duration = 0.2, hold = 0 }}\n",
        soft, stiff, across);
  };
  for (const double across : {0.5, 0.1}) {
    const Scene scene = parse_scene(text(kSoft, kStiff, across), folder / "pad.toml", {}).value();
    World world = test::sfem_world(exec, scene);
    for (int frame = 0; frame < frame_count(scene); frame++) ASSERT_TRUE(step(exec, world));
    const IdentifyInput input{.scene = folder / "fit.toml",
                              .text = text(1e4, 1e4, across),
                              .parameters = {{"body.pad.young", 1e4}, {"body.pad.inside.nodule.young", 1e4}},
                              .most_iterations = 6};
    const Identified fit = identify(exec, input, {noisy_table(world.tools[0], 0.01)}).value();
    const FittedParameter &soft = fit.parameters[0], &stiff = fit.parameters[1];
    std::printf("%.0f (%.0f to %.0f), %.0f (%.0f to %.0f) Pa, residual %.2f %%, %d runs\n", soft.value,
                soft.low, soft.high, stiff.value, stiff.low, stiff.high, 100 * fit.residual, fit.runs);
    EXPECT_NEAR(soft.value, kSoft, 0.1 * kSoft) << across;
    EXPECT_TRUE(soft.low < kSoft && kSoft < soft.high) << across;
    if (across == 0.5) {
      EXPECT_TRUE(stiff.is_observable);
      EXPECT_TRUE(stiff.low < kStiff && kStiff < stiff.high);
      EXPECT_NEAR(stiff.value, kStiff, 0.15 * kStiff);
    } else {
      EXPECT_FALSE(stiff.is_observable);
      EXPECT_FALSE(fit.notes.empty());
    }
  }
}

}  // namespace
}  // namespace turgor

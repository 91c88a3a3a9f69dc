// A nonlinear patch at small strain against the linear one, and under large loads against equilibrium.
#include "turgor/models/sfem/nonlinear_patch.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/sfem/bodies.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor::sfem {
namespace {

/// A patch in the middle of the top of a block that stands on its base.
struct PatchOnBlock {
  Model model;
  Patch linear;
  int refinement;
};

PatchOnBlock patch_on_block(int corners, int refinement, Material material, double radius = 0.014) {
  const Vec3d size{0.06, 0.05, 0.03};
  SolidMesh mesh = hex_block(size, {5, 4, 3});
  distort(mesh, size, 1e-3);
  mesh = with_corners(mesh, corners);
  Body body = block_of(std::move(mesh), material, [](Vec3d x) { return x.z < 1e-9; });
  PatchOnBlock made{
      build(Exec(2), std::move(body), {.precision = Precision::kDouble, .touch_depth = 0.04}).value(),
      {},
      refinement};
  EXPECT_TRUE(compute_green(Exec(2), made.model, std::size_t(4e9)));
  const std::vector<Vec3d> touch{{0.03, 0.025, 0.03}};
  const std::vector<int> elements = patch_elements(made.model, touch, radius);
  made.linear = build_patch(made.model, elements, refinement, touch).value();
  return made;
}

/// Downward forces on the points near the middle [N].
std::vector<double> forces_on(const Patch& patch, double force) {
  std::vector<double> f(3 * patch.points.size());
  for (std::size_t p = 0; p < patch.points.size(); p++) {
    const double far = norm(patch.points[p].x - Vec3d{0.03, 0.025, 0.03});
    if (far < 0.008) f[3 * p + 2] = -force * (1 - far / 0.008);
  }
  return f;
}

std::vector<double> times(const std::vector<double>& matrix, const std::vector<double>& v) {
  std::vector<double> result(v.size());
  for (std::size_t c = 0; c < v.size(); c++)
    for (std::size_t r = 0; r < v.size(); r++) result[r] += matrix[c * v.size() + r] * v[c];
  return result;
}

// At rest, the compliance of a nonlinear patch is the one of the linear patch, for all elements.
TEST(NonlinearPatch, ComplianceAtRestIsTheLinearOne) {
  for (const auto& [corners, refinement] : {std::pair{4, 3}, {8, 2}, {10, 1}, {10, 2}}) {
    const PatchOnBlock block = patch_on_block(corners, refinement, {4e3, 0.43});
    NonlinearPatch patch = make_nonlinear_patch(block.model, block.linear, refinement, {6}).value();
    const std::vector<double> none(3 * block.linear.points.size());
    const Patch found = solve_nonlinear(patch, none, 1).value();
    double largest = 0, error = 0;
    for (std::size_t i = 0; i < found.compliance.size(); i++) {
      largest = std::max(largest, std::abs(block.linear.compliance[i]));
      error = std::max(error, std::abs(found.compliance[i] - block.linear.compliance[i]));
    }
    EXPECT_LT(error, 1e-8 * largest) << corners << " " << refinement;
    EXPECT_EQ(found.points.size(), block.linear.points.size());
    // forces on the coarse body are equivalent
    const std::vector<double> f = forces_on(found, 1e-3), a = coarse_forces(found, f);
    double sum = 0, expected = 0;
    for (std::size_t i = 2; i < a.size(); i += 3) sum += a[i];
    for (const double b : coarse_forces(block.linear, f)) expected += std::abs(b);
    ASSERT_GT(expected, 0);
    std::vector<double> by_vertex(3 * block.model.body.mesh.vertices.size());
    const std::vector<double> linear = coarse_forces(block.linear, f);
    for (std::size_t i = 0; i < linear.size(); i++)
      by_vertex[3 * std::size_t(block.linear.coarse[i / 3]) + i % 3] += linear[i];
    for (std::size_t i = 0; i < a.size(); i++)
      by_vertex[3 * std::size_t(found.coarse[i / 3]) + i % 3] -= a[i];
    for (const double rest : by_vertex) EXPECT_NEAR(rest, 0, 1e-6 * expected);
  }
}

// A strain of half a percent gives the displacement of the linear patch to 1 %; one of 30 % does not.
TEST(NonlinearPatch, SmallForcesGiveLinearDisplacement) {
  const PatchOnBlock block = patch_on_block(10, 1, {4e3, 0.45});
  NonlinearPatch patch = make_nonlinear_patch(block.model, block.linear, 1, {4}).value();
  const auto difference = [&](double force, NonlinearReport& report) {
    const std::vector<double> f = forces_on(block.linear, force), linear = times(block.linear.compliance, f);
    EXPECT_TRUE(solve_nonlinear(patch, f, 20, &report));
    const std::vector<Vec3d> u = point_displacements(patch);
    double largest = 0, error = 0;
    for (std::size_t i = 0; i < linear.size(); i++) {
      largest = std::max(largest, std::abs(linear[i]));
      error = std::max(error, std::abs(u[i / 3][int(i % 3)] - linear[i]));
    }
    return error / largest;
  };
  NonlinearReport report;
  EXPECT_LT(difference(1e-3, report), 0.01);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.strain, 0.005);
  EXPECT_GT(difference(8e-2, report), 0.05);
  EXPECT_TRUE(report.converged);
  EXPECT_GT(report.strain, 0.2);
}

// Nothing is linear if the patch covers the whole body, and the base bears the force. Its tangent
// predicts the displacement of slightly larger forces to second order.
TEST(NonlinearPatch, TangentPredictsTheNextSolution) {
  const PatchOnBlock block = patch_on_block(4, 2, {4e3, 0.4}, 1.0);
  NonlinearPatch patch = make_nonlinear_patch(block.model, block.linear, 2, {5}).value();
  for (const double e : patch.exterior) EXPECT_NEAR(e, 0, 1e-4);
  const std::vector<double> f = forces_on(block.linear, 5e-2), more = forces_on(block.linear, 5.05e-2);
  NonlinearReport report;
  ASSERT_TRUE(solve_nonlinear(patch, f, 20, &report));
  ASSERT_TRUE(report.converged);
  const Patch tangent = solve_nonlinear(patch, f, 1, &report).value();
  const std::vector<Vec3d> before = point_displacements(patch);
  ASSERT_TRUE(solve_nonlinear(patch, more, 20, &report));
  const std::vector<Vec3d> after = point_displacements(patch);
  const std::vector<double> predicted = times(tangent.compliance, more);
  double change = 0, error = 0;
  for (std::size_t i = 0; i < more.size(); i++) {
    const int k = int(i % 3);
    change = std::max(change, std::abs(after[i / 3][k] - before[i / 3][k]));
    error = std::max(error, std::abs(tangent.shift[i / 3][k] + predicted[i] - after[i / 3][k]));
  }
  EXPECT_GT(change, 0);
  EXPECT_LT(error, 0.02 * change);
}

// Wrong elements are refused with a sentence.
TEST(NonlinearPatch, AveragedElementsAreRefused) {
  SolidMesh mesh = hex_block({0.03, 0.03, 0.03}, {2, 2, 2});
  Body body = block_of(std::move(mesh), {4e3, 0.4}, [](Vec3d x) { return x.z < 1e-9; });
  Model model = build(Exec(1), std::move(body), {.formulation = Formulation::kAveraged}).value();
  ASSERT_TRUE(compute_green(Exec(1), model, std::size_t(1e9)));
  const std::vector<Vec3d> touch{{0.015, 0.015, 0.03}};
  const Patch linear = build_patch(model, patch_elements(model, touch, 0.02), 2, touch).value();
  const Result<NonlinearPatch> made = make_nonlinear_patch(model, linear, 2, {});
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("averaged"), std::string::npos);
}

}  // namespace
}  // namespace turgor::sfem

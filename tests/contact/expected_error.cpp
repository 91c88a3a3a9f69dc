// The expected error of a force against the error that a refined mesh shows.
#include "turgor/models/sfem/expected_error.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/sfem/bodies.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/models/sfem/patch.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor {
namespace {

using sfem::Formulation;
using sfem::Model;

constexpr Vec3d kSize{0.03, 0.03, 0.018};
constexpr double kRadius = 0.008, kDepth = 0.0024;  // of the ball and the press [m]

/// Shears and doubles the block, so that the formula was not fitted to its mesh. The upper side stays level.
Vec3d moved(Vec3d x) { return Vec3d{x.x + 0.4 * x.y + 0.3 * x.z, x.y - 0.2 * x.z, 0.9 * x.z} * 2; }

struct Discretization {
  int cells, corners;
  Formulation formulation;
  int refinement;
  double patch = 0.016;  // [m]
};

/// Touched positions: near a vertex of the coarse mesh, and in the middle of a face.
constexpr std::array<Vec3d, 2> kPositions{{{0.0161, 0.0146, kSize.z}, {0.0118, 0.0132, kSize.z}}};

Model model_of(const Discretization& discretization, double poisson) {
  sfem::Body body = sfem::block_of(
      sfem::with_corners(
          hex_block(kSize, {discretization.cells, discretization.cells, discretization.cells * 3 / 5}),
          discretization.corners),
      {2e3, poisson}, [](Vec3d x) { return x.z < 1e-9; });
  for (Vec3d& x : body.mesh.vertices) x = moved(x);
  Result<Model> model =
      sfem::build(Exec(2), std::move(body),
                  {.formulation = discretization.formulation, .touch_depth = 2 * discretization.patch});
  EXPECT_TRUE(model && sfem::prepare_columns(Exec(2), *model));
  return std::move(*model);
}

struct Pressed {
  double force = 0, expected = 0;  // [N] [1]
};

Pressed press(Model& model, const Discretization& discretization, Vec3d position) {
  const std::vector<Vec3d> touches{position};
  const std::vector<int> elements = sfem::patch_elements(model, touches, discretization.patch);
  std::vector<int> vertices;
  for (const int e : sfem::changed_elements(model, elements))
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  sfem::fetch_columns(Exec(2), model, vertices);
  const Result<sfem::Patch> patch = sfem::build_patch(model, elements, discretization.refinement, touches);
  contact::TouchState state = contact::make_touch_state(*patch, 1, {.capacity = 400});
  const std::vector<contact::Tool> tools{{contact::Sphere{kRadius}, 0.0}};
  std::vector<contact::ToolPose> poses(1);
  std::vector<contact::ToolForce> forces(1);
  for (int step = 1; step <= 12; step++) {
    poses[0].pose.position = position + Vec3d{0, 0, kRadius - kDepth * std::min(1.0, step / 10.0)};
    contact::solve_touch_tick(*patch, state, tools, poses, 1e-3, forces);
  }
  return {forces[0].force.z, sfem::expected_error({.corners = discretization.corners,
                                                   .formulation = discretization.formulation,
                                                   .poisson = model.body.materials[0].poisson,
                                                   .edge = sfem::mean_edge(model.body.mesh, elements),
                                                   .refinement = discretization.refinement,
                                                   .patch = discretization.patch,
                                                   .contact = std::sqrt(kRadius * kDepth)})};
}

class ExpectedError : public testing::TestWithParam<double> {};

// The expected error is at least the error against a refined mesh, and not much larger.
TEST_P(ExpectedError, CoversErrorAgainstRefinedMesh) {
  const Discretization finest{12, 10, Formulation::kStandard, 2, 0.011};
  Model reference = model_of(finest, GetParam());
  std::array<double, 2> force{};
  for (std::size_t p = 0; p < 2; p++) force[p] = press(reference, finest, moved(kPositions[p])).force;
  for (const Discretization& discretization :
       {Discretization{6, 10, Formulation::kStandard, 1}, Discretization{6, 10, Formulation::kStandard, 2},
        Discretization{6, 4, Formulation::kAveraged, 2}, Discretization{6, 4, Formulation::kStandard, 2},
        Discretization{6, 8, Formulation::kAveraged, 2}, Discretization{6, 8, Formulation::kStandard, 2}}) {
    Model model = model_of(discretization, GetParam());
    double worst = 0, expected = 0;
    for (std::size_t p = 0; p < 2; p++) {
      const Pressed found = press(model, discretization, moved(kPositions[p]));
      const double error = std::abs(found.force / force[p] - 1);
      EXPECT_LE(error, found.expected)
          << discretization.corners << " corners, r = " << discretization.refinement;
      worst = std::max(worst, error), expected = found.expected;
    }
    RecordProperty(
        std::to_string(discretization.corners) + " corners, r = " + std::to_string(discretization.refinement),
        std::to_string(worst) + " found, expected " + std::to_string(expected));
    if (discretization.corners == 10 && discretization.refinement == 2) {
      EXPECT_LE(expected, 0.03 + 3 * worst) << "an expected error that large is useless";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfTissue, ExpectedError, testing::Values(0.35, 0.47));

}  // namespace
}  // namespace turgor

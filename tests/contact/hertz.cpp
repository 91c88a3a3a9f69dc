// The whole chain against Hertz: a graded block, its sparse factor, Green's functions on demand, the
// superposed patch, and contact.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turgor/contact/touch.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor::contact {
namespace {

constexpr double kCell = 1e-3;   // in the middle of the block [m]
constexpr double kRadius = 0.2;  // of the sphere; Hertz requires small contact radii in comparison [m]
constexpr sfem::Material kMaterial{1e4, 0.3};

/// Planes from -far to far: equal cells up to `inner`, growing ones beyond.
std::vector<double> graded(double inner, double far) {
  std::vector<double> half{0};
  while (half.back() < inner - 1e-9) half.push_back(half.back() + kCell);
  for (double step = kCell; half.back() < far;) half.push_back(half.back() + (step *= 1.4));
  std::vector<double> all;
  for (std::size_t i = half.size(); i-- > 1;) all.push_back(-half[i]);
  all.insert(all.end(), half.begin(), half.end());
  return all;
}

sfem::Model wide_block() {
  const std::vector<double> across = graded(5e-3, 60e-3);
  const std::vector<double> down(across.begin(), across.begin() + std::ptrdiff_t(across.size() / 2 + 1));
  sfem::Body body;
  body.mesh = hex_block(across, across, down);
  body.materials = {kMaterial};
  for (const Vec3d x : body.mesh.vertices) {
    const double far = across.back() - 1e-6;
    body.fixed.push_back(std::abs(x.x) > far || std::abs(x.y) > far || x.z < -far);
  }
  Result<sfem::Model> model = sfem::build(Exec(2), std::move(body), {.precision = sfem::Precision::kDouble});
  EXPECT_TRUE(model) << model.error().message;
  return std::move(*model);
}

sfem::Patch patch_in(sfem::Model& model, int refinement) {
  const std::vector<Vec3d> touch{{0, 0, 0}};
  const std::vector<int> elements = sfem::patch_elements(model, touch, 3.3e-3);
  std::vector<int> vertices;
  for (const int e : elements)
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  sort_unique(vertices);
  sfem::fetch_columns(Exec(2), model, vertices);
  return sfem::build_patch(model, elements, refinement, touch).value();
}

double press(const sfem::Patch& patch, double depth) {
  const std::vector<Tool> tools{{Sphere{kRadius}, 0}};
  TouchState state = make_touch_state(patch, 1, {.capacity = 160});
  std::vector<ToolForce> forces(1);
  for (int i = 1; i <= 20; i++) {
    const std::vector<ToolPose> poses{{{{0, 0, kRadius - depth * std::min(1.0, i / 10.0)}, {}}, false}};
    solve_touch_tick(patch, state, tools, poses, 1e-3, forces);
  }
  EXPECT_FALSE(forces[0].beyond_patch);
  return forces[0].force.z;
}

// With the superposed patch, the force of a sphere on a wide block is within 3 % of Hertz.
TEST(Hertz, SphereOnWideBlockWithinThreePercent) {
  sfem::Model model = wide_block();
  ASSERT_TRUE(sfem::prepare_columns(Exec(2), model));
  const sfem::Patch coarse = patch_in(model, 1), fine = patch_in(model, 3);
  const double stiff = kMaterial.young / (1 - kMaterial.poisson * kMaterial.poisson);
  std::printf("%zu vertices; patch of %d local nodes, %zu points\n", model.body.mesh.vertices.size(),
              fine.local_nodes, fine.points.size());
  double worst_with = 0, worst_without = 0;
  for (const double contact : {0.8e-3, 1.0e-3, 1.2e-3, 1.4e-3, 1.6e-3}) {
    const double depth = contact * contact / kRadius;
    const double hertz = 4.0 / 3 * stiff * std::sqrt(kRadius) * std::pow(depth, 1.5);
    const double with = press(fine, depth) / hertz - 1, without = press(coarse, depth) / hertz - 1;
    std::printf("contact radius %.1f mm: Hertz %.3e N, with the patch %+.2f %%, without %+.2f %%\n",
                1e3 * contact, hertz, 100 * with, 100 * without);
    worst_with = std::max(worst_with, std::abs(with));
    worst_without = std::max(worst_without, std::abs(without));
  }
  EXPECT_LT(worst_with, 0.03);
  EXPECT_GT(worst_without, 2 * worst_with);
}

}  // namespace
}  // namespace turgor::contact

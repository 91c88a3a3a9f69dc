// Tools on lattices whose skin has any position and direction between the nodes.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/contact/bonded_layer.hpp"
#include "turgor/contact/lattice_touch.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::contact {
namespace {

constexpr double kVoxel = 0.001, kStep = 4 * kVoxel, kYoung = 4e3, kPoisson = 0.45;

/// Tissue below a plane: a CT with a soft edge, as in scans. Positions in voxels.
CtVolume half_space(Int3 size, Vec3d on_plane, Vec3d normal) {
  CtVolume ct;
  ct.grid = {.size = size, .spacing = {kVoxel, kVoxel, kVoxel}, .origin = {}, .axes = {}};
  ct.samples.resize(sample_count(ct.grid));
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const double above = dot(Vec3d(Int3{i, j, k}) - on_plane, normal);
        ct.at(i, j, k) = std::int16_t(std::lround(-449 - 500 * std::clamp(above, -1.0, 1.0)));
      }
  return ct;
}

/// A lattice of solid tissue, four voxels per cell, fixed at its bottom and sides.
lattice::Model held_model(const CtVolume& ct) {
  lattice::Params params;
  params.tissue = {
      .law = lattice::TissueLaw::kSolid, .gas = kYoung, .fat = kYoung, .muscle = kYoung, .poisson = kPoisson};
  params.skin.enabled = false;
  params.solver = {.sweeps = 20, .damping = 8};
  lattice::BodyNodes nodes = lattice::classify(Exec(2), ct, nullptr, params).value();
  const Int3 n = nodes.grid.size;
  for (int k = 0; k < n.z; k++)
    for (int j = 0; j < n.y; j++)
      for (int i = 0; i < n.x; i++)
        nodes.fixed[sample_index(nodes.grid, i, j, k)] =
            k == 0 || i == 0 || j == 0 || i == n.x - 1 || j == n.y - 1;
  return lattice::assemble(Exec(2), nodes, nullptr, params).value();
}

/// Results of a ball that presses the skin at `position` along the normal by `depth`.
struct Found {
  double force = 0;   // along the normal [N]
  double inside = 0;  // largest depth of the drawn skin in the ball [m]
  double below = 0;   // distance of the ball to the drawn skin on the normal below it [m]
};
Found press(const CtVolume& ct, Vec3d position, Vec3d normal, double radius, double depth) {
  constexpr int kPressFrames = 20, kFrames = 40;
  const lattice::Model model = held_model(ct);
  lattice::State state = lattice::make_state(model);
  const lattice::BodySurface surface = lattice::build_surface(model, state.cuts, &ct);
  const std::vector<Tool> tools = {{Sphere{radius}, 0}};
  std::vector<ToolPose> at = {{{position + normal * radius, {}}, false}};
  std::vector<ToolForce> forces(1);
  LatticeTouch touch = make_lattice_touch(model, state.cuts, surface, at);
  for (int f = 1; f <= kFrames; f++) {
    at[0].pose.position = position + normal * (radius - depth * std::min(1.0, double(f) / kPressFrames));
    contact::step_with_tools(Exec(2), model, state, touch, tools, at, {}, 1.0 / 60, forces);
  }
  Found found{.force = dot(forces[0].force, normal)};
  double nearest = 1;
  for (const Vec3 v : lattice::deformed_surface(model, state, surface, lattice::Shown::kNothing).vertices) {
    const double outside = distance(tools[0].shape, at[0].pose, Vec3d(v)).distance;
    found.inside = std::max(found.inside, -outside);
    const Vec3d from = Vec3d(v) - position, lateral = from - normal * dot(from, normal);
    if (dot(from, normal) > -2 * depth && norm(lateral) < nearest)
      nearest = norm(lateral), found.below = outside;
  }
  return found;
}

/// Size of the CT and the middle of its skin, in voxels; `fraction` shifts the skin within a cell.
constexpr Int3 kSize{81, 81, 57};
Vec3d middle_of_skin(double fraction) { return {40.7, 38.7, 36 + 4 * fraction}; }
constexpr double kBase = -0.5 * kVoxel;  // height of the fixed nodes [m]

// The force of a press depends little on the skin's position and direction within the cells.
TEST(LatticeSkinTouch, ForceIndependentOfSkinInCell) {
  constexpr double kRadius = 0.01, kDepth = 0.004;  // 2.5 cells, one cell
  for (const Vec3d direction : {Vec3d{0, 0, 1}, Vec3d{0.3, 0.2, 1}, Vec3d{1, 0.9, 1}}) {
    const Vec3d normal = normalized(direction);
    double least = 1e9, most = 0;
    for (const double fraction : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      const Vec3d position = middle_of_skin(fraction);
      const Found found =
          press(half_space(kSize, position, normal), position * kVoxel, normal, kRadius, kDepth);
      const double expected =
          force_on_bonded_layer(kYoung, kPoisson, kRadius, kDepth, position.z * kVoxel - kBase);
      std::printf("normal %.2f %.2f %.2f, skin at %.1f: %.4f N, %.3f of a layer's %.4f N\n", normal.x,
                  normal.y, normal.z, fraction, found.force, found.force / expected, expected);
      EXPECT_NEAR(found.force, expected, 0.08 * expected) << "N";
      least = std::min(least, found.force), most = std::max(most, found.force);
    }
    EXPECT_LT(most - least, 0.05 * (most + least)) << "N: within 5 % of the mean";
  }
}

// A ball with a radius of ten cells has the force of a bonded layer.
TEST(LatticeSkinTouch, LargeBallMatchesBondedLayer) {
  constexpr double kRadius = 0.04, kDepth = 0.0016;
  for (const double fraction : {0.2, 0.6}) {
    const Vec3d position = middle_of_skin(fraction), normal = normalized(Vec3d{-0.4, 0.5, 1});
    const Found found =
        press(half_space(kSize, position, normal), position * kVoxel, normal, kRadius, kDepth);
    const double expected =
        force_on_bonded_layer(kYoung, kPoisson, kRadius, kDepth, position.z * kVoxel - kBase);
    std::printf("skin at %.1f: %.4f N, %.3f of a layer's\n", fraction, found.force, found.force / expected);
    EXPECT_NEAR(found.force, expected, 0.08 * expected) << "N: the block's sides are fixed too";
  }
}

// The drawn skin lies on the tool within a fifth of a cell.
TEST(LatticeSkinTouch, DrawnSkinLiesOnTool) {
  constexpr double kRadius = 0.02, kDepth = 0.006;
  for (const Vec3d direction : {Vec3d{0, 0, 1}, Vec3d{0.5, -0.3, 1}})
    for (const double fraction : {0.1, 0.5, 0.9}) {
      const Vec3d normal = normalized(direction), position = middle_of_skin(fraction);
      const Found found =
          press(half_space(kSize, position, normal), position * kVoxel, normal, kRadius, kDepth);
      std::printf("skin at %.1f: %.2f mm inside, %.2f mm off below\n", fraction, found.inside * 1e3,
                  found.below * 1e3);
      EXPECT_LT(found.inside, 0.15 * kStep) << "m";
      EXPECT_LT(std::abs(found.below), 0.2 * kStep) << "m";
    }
}

}  // namespace
}  // namespace turgor::contact

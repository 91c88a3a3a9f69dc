// Tools on lattices whose skin lies anywhere between the nodes, and any way.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/contact/bonded_layer.hpp"
#include "turgor/contact/lattice_touch.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::contact {
namespace {

constexpr double kVoxel = 0.001, kStep = 4 * kVoxel, kYoung = 4e3, kPoisson = 0.45;

/// Tissue below a plane: a CT in which it ends softly, as scans show it. Places in voxels.
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

/// A lattice of solid tissue, four voxels a step, held at its bottom and sides.
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

/// What a ball found that went `depth` into the skin at `place`, along the normal.
struct Found {
  double force = 0;    // along the normal [N]
  double inside = 0;   // the deepest point of the drawn skin in the ball [m]
  double beneath = 0;  // of the drawn skin on the normal below the ball [m]
};
Found press(const CtVolume& ct, Vec3d place, Vec3d normal, double radius, double depth) {
  constexpr int kGo = 20, kFrames = 40;
  const lattice::Model model = held_model(ct);
  lattice::State state = lattice::make_state(model);
  const lattice::BodySurface surface = lattice::build_surface(model, state, &ct);
  const std::vector<Tool> tools = {{Sphere{radius}, 0}};
  std::vector<ToolPose> at = {{{place + normal * radius, {}}, false}};
  std::vector<ToolForce> forces(1);
  LatticeTouch touch = make_lattice_touch(model, state, surface, at);
  for (int f = 1; f <= kFrames; f++) {
    at[0].pose.position = place + normal * (radius - depth * std::min(1.0, double(f) / kGo));
    contact::step(Exec(2), model, state, touch, tools, at, {}, 1.0 / 60, forces);
  }
  Found found{.force = dot(forces[0].force, normal)};
  double nearest = 1;
  for (const Vec3 v : lattice::deformed_surface(model, state, surface, lattice::Shown::kNothing).vertices) {
    const double outside = distance(tools[0].shape, at[0].pose, Vec3d(v)).distance;
    found.inside = std::max(found.inside, -outside);
    const Vec3d from = Vec3d(v) - place, aside = from - normal * dot(from, normal);
    if (dot(from, normal) > -2 * depth && norm(aside) < nearest)
      nearest = norm(aside), found.beneath = outside;
  }
  return found;
}

/// Where in the cells, and which way, the skin of a test lies: its middle in voxels.
constexpr Int3 kSize{81, 81, 57};
Vec3d middle_of_skin(double fraction) { return {40.7, 38.7, 36 + 4 * fraction}; }
constexpr double kBase = -0.5 * kVoxel;  // the nodes that are held [m]

TEST(lattice_skin_touch, the_force_of_a_press_does_not_know_where_the_skin_lies_in_the_cells) {
  constexpr double kRadius = 0.01, kDepth = 0.004;  // two and a half steps, one step
  for (const Vec3d way : {Vec3d{0, 0, 1}, Vec3d{0.3, 0.2, 1}, Vec3d{1, 0.9, 1}}) {
    const Vec3d normal = normalized(way);
    double least = 1e9, most = 0;
    for (const double fraction : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      const Vec3d place = middle_of_skin(fraction);
      const Found found = press(half_space(kSize, place, normal), place * kVoxel, normal, kRadius, kDepth);
      const double wanted =
          force_on_bonded_layer(kYoung, kPoisson, kRadius, kDepth, place.z * kVoxel - kBase);
      std::printf("normal %.2f %.2f %.2f, skin at %.1f: %.4f N, %.3f of a layer's %.4f N\n", normal.x,
                  normal.y, normal.z, fraction, found.force, found.force / wanted, wanted);
      EXPECT_NEAR(found.force, wanted, 0.08 * wanted) << "N";
      least = std::min(least, found.force), most = std::max(most, found.force);
    }
    EXPECT_LT(most - least, 0.05 * (most + least)) << "N: within 5 % of their middle";
  }
}

TEST(lattice_skin_touch, a_ball_of_ten_steps_is_carried_as_a_layer_carries_it) {
  constexpr double kRadius = 0.04, kDepth = 0.0016;
  for (const double fraction : {0.2, 0.6}) {
    const Vec3d place = middle_of_skin(fraction), normal = normalized(Vec3d{-0.4, 0.5, 1});
    const Found found = press(half_space(kSize, place, normal), place * kVoxel, normal, kRadius, kDepth);
    const double wanted = force_on_bonded_layer(kYoung, kPoisson, kRadius, kDepth, place.z * kVoxel - kBase);
    std::printf("skin at %.1f: %.4f N, %.3f of a layer's\n", fraction, found.force, found.force / wanted);
    EXPECT_NEAR(found.force, wanted, 0.08 * wanted) << "N: the block's sides are held, too";
  }
}

TEST(lattice_skin_touch, the_skin_that_is_drawn_lies_on_the_tool) {
  constexpr double kRadius = 0.02, kDepth = 0.006;
  for (const Vec3d way : {Vec3d{0, 0, 1}, Vec3d{0.5, -0.3, 1}})
    for (const double fraction : {0.1, 0.5, 0.9}) {
      const Vec3d normal = normalized(way), place = middle_of_skin(fraction);
      const Found found = press(half_space(kSize, place, normal), place * kVoxel, normal, kRadius, kDepth);
      std::printf("skin at %.1f: %.2f mm inside, %.2f mm off beneath\n", fraction, found.inside * 1e3,
                  found.beneath * 1e3);
      EXPECT_LT(found.inside, 0.15 * kStep) << "m";
      EXPECT_LT(std::abs(found.beneath), 0.2 * kStep) << "m";
    }
}

}  // namespace
}  // namespace turgor::contact

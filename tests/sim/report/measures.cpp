#include "turgor/sim/report/measures.hpp"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "tests/sim/block_scene.hpp"

namespace turgor {
namespace {

/// Tension at the block's cut, which runs along z, with Langer's lines in the given direction.
CutTension tension_with(const std::string& direction, const std::string& law = "\"fiber\"") {
  const Exec exec(1);
  const Scene scene = test::block_scene(
      test::fresh_folder(),
      {"body.block.skin={ law = " + law + ", tension = [60, 30], direction = " + direction + " }"});
  const World world = test::block_world(exec, scene);
  const LatticeBody& body = world.lattice_bodies[0];
  return cut_tension(body.model, lattice::lay_blade(body.model, body.state, world.cuts[0].blade).value());
}

// A cut along Langer's lines is opened by the tension across them.
TEST(Measures, CutAlongLinesOpensByCrossTension) {
  const CutTension along = tension_with("[0, 0, 1]");
  EXPECT_NEAR(along.angle, 0, 0.1);
  EXPECT_NEAR(along.opening, 30, 0.1);
  EXPECT_NEAR(along.lengthwise, 60, 0.1);
  const CutTension across = tension_with("[1, 0, 0]");
  EXPECT_NEAR(across.angle, 90, 0.1);
  EXPECT_NEAR(across.opening, 60, 0.1);
  const CutTension oblique = tension_with("[1, 0, 1]");
  EXPECT_NEAR(oblique.angle, 45,
              0.2);  // four cells from the cut's ends the skin bends around the block's edges
  EXPECT_NEAR(oblique.opening, 45, 0.1);
}

/// A cylinder of fat along z with a core of bone, or a slab, in a CT with rotated axes; voxels of 3 mm.
struct TurnedBody {
  Mat3d turn;  // lattice to patient
  lattice::Model model;
};
constexpr double kRadius = 0.06;

TurnedBody turned_body(bool is_round, double degrees, Vec3d direction, bool by_field) {
  const double c = std::cos(degrees * std::numbers::pi / 180), s = std::sin(degrees * std::numbers::pi / 180);
  TurnedBody body;
  body.turn = {{{c, s, 0}, {-s * c, c * c, s}, {s * s, -c * s, c}}};
  CtVolume ct;
  ct.grid = {.size = {56, 56, 40}, .spacing = {0.003, 0.003, 0.003}, .axes = body.turn};
  ct.grid.origin = body.turn * Vec3d{-0.0825, -0.0825, -0.0585};
  ct.samples.assign(sample_count(ct.grid), kAirHu);
  VectorVolume field{ct.grid, std::vector<Vec3>(sample_count(ct.grid), Vec3(body.turn * direction))};
  for (int k = 2; k < 38; k++)
    for (int j = 2; j < 54; j++)
      for (int i = 2; i < 54; i++) {
        const Vec3d local = Vec3d(Int3{i, j, k}) * 0.003 - Vec3d{0.0825, 0.0825, 0.0585};
        const double depth = is_round ? kRadius - std::hypot(local.x, local.y) : local.y + kRadius;
        if (depth > 0) ct.at(i, j, k) = depth > 0.03 ? 1000 : -100;
      }
  lattice::Params params;
  params.block = {1, 1, 1};
  params.skin.direction = by_field ? Vec3d{0, 0, 1} : body.turn * direction;
  body.model = lattice::build(Exec(1), ct, {.lines = by_field ? &field : nullptr}, params).value();
  return body;
}

double angle_of_cut(const TurnedBody& body, Vec3d line) {
  const Vec3d middle{0.0007, -kRadius, 0.0004};
  const lattice::Incision cut{
      .name = "cut", .from = body.turn * (middle - line * 0.012), .to = body.turn * (middle + line * 0.012)};
  const lattice::State state = lattice::make_state(body.model);
  return cut_tension(body.model, lattice::lay_blade(body.model, state, cut).value()).angle;
}

// The angle to Langer's lines is measured on the smooth skin, not on the lattice cells.
TEST(Measures, AngleToLinesIsMeasuredOnSkin) {
  const double half = std::sqrt(0.5);
  for (const bool is_round : {false, true})
    for (const double degrees : {0.0, 27.0})
      for (const bool by_field : {false, true})
        for (const Vec3d direction : {Vec3d{0, 0, 1}, Vec3d{1, 0, 0}, Vec3d{0, 0.6, 1}}) {
          if (is_round && direction.y != 0) continue;  // on the cylinder such lines turn along the cut
          const TurnedBody body = turned_body(is_round, degrees, direction, by_field);
          const Vec3d along = normalized(Vec3d{direction.x, 0, direction.z}), across{along.z, 0, -along.x};
          const std::string where =
              fmt::format("round {}, turned {}°, field {}, lines ({}, {}, {})", is_round, degrees, by_field,
                          direction.x, direction.y, direction.z);
          EXPECT_LT(angle_of_cut(body, along), 1) << where;
          EXPECT_GT(angle_of_cut(body, across), 89) << where;
          EXPECT_NEAR(angle_of_cut(body, (along + across) * half), 45, 1) << where;
        }
}

// The area law has the same tension in all directions.
TEST(Measures, AreaLawIsIsotropic) { EXPECT_NEAR(tension_with("[1, 0, 0]", "\"area\"").opening, 45, 1e-9); }

// Wound series start with the blade, and solver samples are taken at snapshots.
TEST(Measures, SeriesStartWithBlade) {
  const Exec exec(1);
  World world = test::block_world(exec, test::block_scene(test::fresh_folder()));
  Measures measures = make_measures(world);
  for (int frame = 1; frame <= 10; frame++)
    measure_frame(exec, world, step(exec, world, frame % 5 == 0).value(), frame % 5 == 0, measures);
  EXPECT_EQ(measures.frame_seconds.size(), 10u);
  ASSERT_EQ(measures.cuts.size(), 1u);
  EXPECT_EQ(measures.cuts[0].series.size(), 8u);
  EXPECT_NEAR(measures.cuts[0].series.front().time, 0.06, 1e-9);
  EXPECT_GT(measures.cuts[0].series.back().gape_max, measures.cuts[0].series.front().gape_max);
  ASSERT_EQ(measures.solver.size(), 2u);
  EXPECT_GT(measures.solver[0].residual.largest, 0);
  EXPECT_TRUE(std::isfinite(measures.solver[1].energy));
}

}  // namespace
}  // namespace turgor

// A piece of skin is cut free and leaves the body; it and its wound have the sizes that mechanics demands.
#include "turgor/models/lattice/specimen.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

constexpr double kFrameTime = 1.0 / 60;

/// A flat block under tense skin, fixed at its sides and bottom, that loses a piece.
struct Excised {
  Model model;
  State state;
  BladePath path;
  Specimen specimen;

  Excised(const Params& params, Excision excision, double depth, double young = 2e3, Int3 size = {25, 25, 6},
          double spacing = 0.003, const Exec& exec = Exec(1)) {
    Block block{.size = size, .spacing = spacing, .young = young};
    block.is_fixed = [size](Int3 p) {
      return p.x == 0 || p.y == 0 || p.z == 0 || p.x == size.x - 1 || p.y == size.y - 1;
    };
    model = block_model(block, params);
    state = make_state(model);
    excision.center = {(size.x / 2 + 0.31) * spacing, (size.y / 2 + 0.17) * spacing, (size.z - 1) * spacing};
    Incision blade{.name = "mole", .depth = depth};
    blade.path = excision_outline(model, state, excision).value();
    blade.excision = excision;
    const Result<BladePath> laid = lay_blade(model, state, blade);
    EXPECT_TRUE(laid) << laid.error().message;
    path = *laid;
    cut_edges(model, state, path, 0, 1, 0);
    const Result<Specimen> made = excise_piece(exec, model, state, path, 0);
    EXPECT_TRUE(made) << made.error().message;
    if (made) specimen = *made;
  }
};

// A piece has the volume and mass of a disc, or of the segment of two circles. Without tension neither it nor
// its wound changes.
TEST(Specimen, WithoutTensionKeepsItsSize) {
  Params params = solid_params(5, 2, 0);
  for (const double width : {0.03, 0.014}) {
    constexpr double kLength = 0.03, kDepth = 0.0071;
    const Excised block(params, {.direction = {1, 0.3, 0}, .length = kLength, .width = width}, kDepth);
    const double radius = (kLength * kLength + width * width) / (4 * width),
                 half = std::asin(kLength / 2 / radius),
                 area = radius * radius * (2 * half - std::sin(2 * half)), volume = area * kDepth;
    const Specimen& piece = block.specimen;
    std::printf("volume %.4f ml (%.4f), mass %.4f g, area %.1f mm2 (%.1f), speed %.1e\n", 1e6 * piece.volume,
                1e6 * volume, 1e3 * piece.mass, 1e6 * piece.free.area, 1e6 * area, piece.speed);
    EXPECT_NEAR(piece.volume, volume, 0.02 * volume);
    EXPECT_NEAR(piece.mass, 1000 * piece.volume, 1e-3 * piece.mass);
    EXPECT_NEAR(piece.free.length, kLength, 1e-3 * kLength);
    EXPECT_NEAR(piece.free.width, width, 1e-2 * width);
    EXPECT_NEAR(piece.free.area, area, 0.02 * area);
    State state = block.state;
    for (int n = 0; n < 10; n++) step(Exec(1), block.model, state, {}, kFrameTime);
    const Opening opening = opening_of(block.model, state, block.path).value();
    EXPECT_NEAR(opening.size.length, kLength, 1e-3 * kLength);
    EXPECT_LT(opening.displacement, 1e-6) << "m";
  }
}

// The wound of a tense skin is larger than the mark, and the specimen smaller.
TEST(Specimen, TensionOpensWoundAndShrinksPiece) {
  Excised block(solid_params(5, 2, 45), {.direction = {1, 0, 0}, .length = 0.03, .width = 0.03}, 0.006);
  for (int n = 0; n < 80; n++) ASSERT_TRUE(step(Exec(1), block.model, block.state, {}, kFrameTime).finite);
  const Opening opening = opening_of(block.model, block.state, block.path).value();
  const Specimen& piece = block.specimen;
  std::printf("wound %.1f x %.1f mm, specimen %.1f x %.1f mm, in place %.1f x %.1f mm, speed %.1e\n",
              1e3 * opening.size.length, 1e3 * opening.size.width, 1e3 * piece.free.length,
              1e3 * piece.free.width, 1e3 * piece.in_place.length, 1e3 * piece.in_place.width, piece.speed);
  EXPECT_GT(opening.size.length, 0.031);
  EXPECT_LT(piece.free.length, 0.028);
  EXPECT_NEAR(piece.free.length, piece.free.width, 0.03 * piece.free.width);
  // nothing of the piece is drawn above its floor, which lies 4.65 mm below the nodes of the skin
  const BodySurface surface = build_surface(block.model, block.state.cuts);
  const Vec3d center = axis_of(block.path).points[axis_of(block.path).points.size() / 2];
  for (const Vec3 x : surface.rest) {
    const Vec3d away = Vec3d(x) - center;
    EXPECT_FALSE(std::hypot(away.x, away.y) < 0.013 && away.z > -0.0045) << x.x << " " << x.y << " " << x.z;
  }
}

// A free piece shrinks to the stretch r at which its fibers have no tension: K (1 − r) = T in each direction.
TEST(Specimen, ShrinksAsFreeMembrane) {
  constexpr double kAlong = 50, kAcross = 20, kStiffness = 400;
  Params params = solid_params(5, 4, 0);
  params.skin.tension_along = kAlong, params.skin.tension_across = kAcross;
  params.skin.stiffness = kStiffness, params.skin.shear = kStiffness / 2, params.skin.amplification = 0;
  params.skin.direction = {1, 0, 0};
  const Excised block(params, {.direction = {1, 0, 0}, .length = 0.03, .width = 0.03}, 0.0067, 1000,
                      {21, 21, 4});
  const Specimen& piece = block.specimen;
  const double along = piece.free.length / piece.in_place.length,
               across = piece.free.width / piece.in_place.width;
  std::printf("specimen %.4f along, %.4f across, expected %.4f and %.4f; speed %.1e\n", along, across,
              1 - kAlong / kStiffness, 1 - kAcross / kStiffness, piece.speed);
  EXPECT_NEAR(along, 1 - kAlong / kStiffness, 0.01);
  EXPECT_NEAR(across, 1 - kAcross / kStiffness, 0.01);
}

// A floor below the body is refused.
TEST(Specimen, FloorBelowBodyIsRefused) {
  const Model model = block_model({.size = {15, 15, 5}, .spacing = 0.004}, solid_params(5, 2, 45));
  const State state = make_state(model);
  Incision blade{.name = "mole", .depth = 0.021};
  blade.excision =
      Excision{.center = {0.028, 0.028, 0.016}, .direction = {1, 0, 0}, .length = 0.02, .width = 0.02};
  blade.path = excision_outline(model, state, *blade.excision).value();
  const Result<BladePath> laid = lay_blade(model, state, blade);
  ASSERT_FALSE(laid);
  EXPECT_NE(laid.error().message.find("excision 'mole': the floor of the excision leaves the body"),
            std::string::npos)
      << laid.error().message;
}

}  // namespace
}  // namespace turgor::lattice

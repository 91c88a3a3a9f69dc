// Closure of an excised wound against closed forms of a membrane under tension.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/specimen.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {
namespace {

//// A wide membrane on tissue that bears little, which loses a lens.
struct ExcisedMembrane {
  static constexpr double kCell = 0.003;
  static constexpr Int3 kSize{61, 61, 5};
  Model model;
  State state;
  BladePath path;
  Specimen specimen;
  WoundClosure closure;

  ExcisedMembrane(Params params, Excision excision) {
    params.tissue.poisson = 0.3;
    Block block{.size = kSize, .spacing = kCell, .young = 1000};
    block.is_fixed = [](Int3 p) { return p.x == 0 || p.y == 0 || p.x == kSize.x - 1 || p.y == kSize.y - 1; };
    model = block_model(block, params);
    state = make_state(model);
    excision.center = {(kSize.x / 2 + 0.31) * kCell, (kSize.y / 2 + 0.17) * kCell, (kSize.z - 1) * kCell};
    Incision blade{.name = "mole", .depth = 0.0067};
    blade.path = excision_outline(model, state, excision).value();
    blade.excision = excision;
    path = lay_blade(model, state, blade).value();
    cut_edges(model, state, path, 0, 1, 0);
    specimen = excise_piece(Exec(2), model, state, path, 0).value();
  }
  /// Closing force after a pull of half a second and some time of rest [N].
  double close(double bite) {
    closure = lay_stitches(model, state.cuts, path, {.spacing = 0.004, .bite = bite, .depth = 2e-4}).value();
    closure.thread = {.stiffness = 200, .strength = 50}, closure.pull_out = 50;
    const Pull pull{.duration = 0.5};
    constexpr double kFrameTime = 1.0 / 60;
    for (int n = 1; n <= 110; n++) {
      pull_stitches(state.motion, pull, n * kFrameTime, closure);
      PointSprings springs;
      append_springs(closure, springs.all);
      make_terms(springs);
      springs.refresh = [&](const State& now) { update_springs(model, now.motion, closure, springs.all); };
      EXPECT_TRUE(step(Exec(2), model, state, {.springs = &springs}, kFrameTime).finite);
      update_multipliers(model, state.motion, closure);
      end_overloaded_stitches(state.motion, n * kFrameTime, closure);
    }
    return closing_force(closure, state.motion);
  }
  double gape() const {
    double most = 0;
    for (const Stitch& stitch : closure.stitches) most = std::max(most, gape_under(stitch, state.motion));
    return most;
  }
};

/// Skin without stiffening and with equal stiffness in all directions.
Params membrane(double along, double across, double stiffness) {
  Params params = solid_params(5, 4, 0);
  params.skin.tension_along = along, params.skin.tension_across = across;
  params.skin.stiffness = stiffness, params.skin.shear = stiffness / 2, params.skin.amplification = 0;
  params.skin.direction = {1, 0, 0};
  return params;
}

// A lens of width w and length L is closed in a wide membrane with tension T and stiffness E. Its lips are a
// distribution of dislocations, whose tractions add up to E w/π:
//   F = T L + E w/π
TEST(ExcisedWound, ClosingForceIsTensionTimesLengthAndStretch) {
  constexpr double kLength = 0.045, kWidth = 0.012, kTension = 40, kStiffness = 400;
  ExcisedMembrane body(membrane(kTension, kTension, kStiffness),
                       {.direction = {1, 0, 0}, .angle = 20, .length = kLength, .width = kWidth});
  const double force = body.close(0.0045), tension = kTension * kLength,
               expected = tension + kStiffness * kWidth / std::numbers::pi;
  std::printf("closing force %.3f N, expected %.3f N of which tension %.3f N; gape %.2f mm\n", force,
              expected, tension, 1e3 * body.gape());
  EXPECT_LT(body.gape(), 3e-4) << "m";
  EXPECT_NEAR(force, expected, 0.15 * expected) << "N";
}

// A free piece shrinks to the stretch r at which its fibers have no tension: K (1 − r) = T in each direction.
TEST(ExcisedWound, SpecimenShrinksAsFreeMembrane) {
  constexpr double kAlong = 50, kAcross = 20, kStiffness = 400;
  const ExcisedMembrane body(membrane(kAlong, kAcross, kStiffness),
                             {.direction = {1, 0, 0}, .length = 0.04, .width = 0.04});
  const Specimen& piece = body.specimen;
  std::printf("specimen %.4f along, %.4f across, expected %.4f and %.4f; speed %.1e\n",
              piece.free.length / piece.in_place.length, piece.free.width / piece.in_place.width,
              1 - kAlong / kStiffness, 1 - kAcross / kStiffness, piece.speed);
  EXPECT_NEAR(piece.free.length / piece.in_place.length, 1 - kAlong / kStiffness, 0.01);
  EXPECT_NEAR(piece.free.width / piece.in_place.width, 1 - kAcross / kStiffness, 0.01);
}

// Least force closes a lens along the lines of largest tension.
TEST(ExcisedWound, LeastForceIsAlongLinesOfTension) {
  double force[3];
  for (int n = 0; n < 3; n++) {
    ExcisedMembrane body(membrane(60, 15, 400),
                         {.direction = {1, 0, 0}, .angle = 45.0 * n, .length = 0.036, .width = 0.012});
    force[n] = body.close(0.0045);
  }
  std::printf("closing force %.3f, %.3f and %.3f N at 0, 45 and 90 degrees to the lines\n", force[0],
              force[1], force[2]);
  EXPECT_LT(force[0], force[1]);
  EXPECT_LT(force[1], force[2]);
  EXPECT_NEAR(force[2] - force[0], (60 - 15) * 0.036, 0.25 * (60 - 15) * 0.036) << "N";
}

}  // namespace
}  // namespace turgor::lattice

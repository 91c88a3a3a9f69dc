// Closure of an excised wound against closed forms and finite elements of a membrane under tension.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "app/lens_elements.hpp"
#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/specimen.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {
namespace {

/// Tissue below the membrane.
struct Bed {
  double young = 1000;         // bears little [Pa]
  bool is_fixed = false;       // at its bottom
  Undermining undermine = {};  // around the lens
};

/// A wide membrane on tissue, which loses a lens.
struct ExcisedMembrane {
  static constexpr double kCell = 0.003;
  static constexpr Int3 kSize{41, 41, 4};
  static constexpr double kInSkin = 2e-5;  // depth of the deep strands, so that they pull on no tissue [m]
  Model model;
  State state;
  BladePath path;
  WoundClosure closure;

  ExcisedMembrane(Params params, Excision excision, const Bed& bed = {}) {
    params.tissue.poisson = 0.3;
    Block block{.size = kSize, .spacing = kCell, .young = bed.young};
    block.is_fixed = [&bed](Int3 p) {
      return p.x == 0 || p.y == 0 || p.x == kSize.x - 1 || p.y == kSize.y - 1 || (bed.is_fixed && p.z == 0);
    };
    model = block_model(block, params);
    state = make_state(model);
    excision.center = {(kSize.x / 2 + 0.31) * kCell, (kSize.y / 2 + 0.17) * kCell, (kSize.z - 1) * kCell};
    Incision blade{.name = "mole", .depth = 0.0067};
    blade.path = excision_outline(model, state, excision).value();
    blade.excision = excision;
    blade.undermine = bed.undermine;
    path = lay_blade(model, state, blade).value();
    cut_edges(model, state, path, 0, 1, 0);
    excise(model, state, find_piece(model, state.cuts, 0).value());
  }
  /// Closing force when the stitches hold their points where they were before the cut, relative to each other
  /// [N].
  double close(double bite) {
    closure =
        lay_stitches(model, state.cuts, path, {.spacing = 0.0036, .bite = bite, .depth = kInSkin}).value();
    closure.walls.clear();  // a membrane has no walls
    closure.thread = {.stiffness = 200, .strength = 50}, closure.pull_out = 50;
    constexpr int kPull = 45, kRest = 25;  // steps
    const Pull pull{.duration = kPull / 60.0};
    constexpr double kFrameTime = 1.0 / 60;
    for (int n = 1; n <= kPull + kRest; n++) {
      if (n <= kPull) pull_stitches(state.motion, pull, n * kFrameTime, closure);
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
};

/// Skin without stiffening and with equal stiffness in all directions.
Params membrane(double along, double across, double stiffness) {
  Params params = solid_params(5, 4, 0);
  params.skin.tension_along = along, params.skin.tension_across = across;
  params.skin.stiffness = stiffness, params.skin.shear = stiffness / 2, params.skin.amplification = 0;
  params.skin.direction = {1, 0, 0};
  return params;
}

// A narrow lens of width w and length L in a wide membrane with tension T and stiffness E, whose lips are
// bonded: a distribution of dislocations, whose tractions add up to E w/π.
//   F = T L + E w/π
TEST(LensElements, NarrowLensHasForceOfDislocations) {
  const LensMembrane lens{.side = 0.4,
                          .length = 0.036,
                          .width = 0.0005,
                          .tension = 0.01,
                          .stiffness = 400,
                          .stitches = 24,
                          .bite = 0.0008,
                          .patch = 0.0008,
                          .pushes = true};
  const double expected = lens.tension * lens.length + lens.stiffness * lens.width / std::numbers::pi;
  EXPECT_NEAR(closing_force_of_elements(lens, 20) / expected, 1, 0.04);
}

// A lens is closed with the force of a membrane of finite elements with the same sides and stitches. The
// membrane of the lattice also bulges, and moves tissue.
TEST(ExcisedWound, ClosingForceIsThatOfElements) {
  constexpr double kLength = 0.036, kWidth = 0.0105, kStiffness = 400, kBite = 0.0045,
                   kTensions[2] = {20, 50};
  double force[2];
  for (const int n : {0, 1}) {
    ExcisedMembrane body(membrane(kTensions[n], kTensions[n], kStiffness),
                         {.direction = {1, 0, 0}, .angle = 10, .length = kLength, .width = kWidth});
    force[n] = body.close(kBite);
    const double expected =
        closing_force_of_elements({.side = (ExcisedMembrane::kSize.x - 1) * ExcisedMembrane::kCell,
                                   .length = kLength,
                                   .width = kWidth,
                                   .tension = kTensions[n],
                                   .stiffness = kStiffness,
                                   .stitches = 10,
                                   .bite = kBite,
                                   .patch = ExcisedMembrane::kCell},
                                  14);
    std::printf("tension %.0f N/m: closing force %.3f N, elements %.3f N\n", kTensions[n], force[n],
                expected);
    EXPECT_NEAR(force[n] / expected, 1, 0.1);
  }
  const double difference = kTensions[1] - kTensions[0], change = force[1] - force[0];
  std::printf("change with the tension %.3f N, closed form %.3f N\n", change, difference * kLength);
  EXPECT_GT(change, difference * kLength) << "N";
  EXPECT_LT(change, difference * (kLength + 2 * kBite)) << "N";
}

// Skin on a firm bed is closed with less force where it is undermined, the less the wider the flaps: a flap
// of width w yields like a strip, by w/(K + E d/4) per force and length, instead of shearing its bed.
TEST(ExcisedWound, UnderminingLowersClosingForce) {
  const Excision lens{.direction = {1, 0, 0}, .angle = 10, .length = 0.036, .width = 0.0105};
  double last = 1e9;
  for (const double width : {0.0, 0.009, 0.018}) {
    const Bed bed{.young = 1e4, .is_fixed = true, .undermine = {.width = width, .depth = 0.0045}};
    ExcisedMembrane body(membrane(20, 20, 400), lens, bed);
    const double force = body.close(0.0045);
    std::printf("undermined by %.0f mm: closing force %.3f N\n", 1e3 * width, force);
    EXPECT_LT(force, 0.95 * last) << width << " m";
    last = force;
  }
}

// Least force closes a lens along the lines of largest tension.
TEST(ExcisedWound, LeastForceIsAlongLinesOfTension) {
  double force[3];
  for (int n = 0; n < 3; n++) {
    ExcisedMembrane body(membrane(60, 15, 400),
                         {.direction = {1, 0, 0}, .angle = 45.0 * n, .length = 0.036, .width = 0.0105});
    force[n] = body.close(0.0045);
  }
  std::printf("closing force %.3f, %.3f and %.3f N at 0, 45 and 90 degrees to the lines\n", force[0],
              force[1], force[2]);
  EXPECT_LT(force[0], force[1]);
  EXPECT_LT(force[1], force[2]);
  EXPECT_NEAR(force[2] - force[0], (60 - 15) * 0.036, 0.15 * (60 - 15) * 0.036) << "N";
}

}  // namespace
}  // namespace turgor::lattice

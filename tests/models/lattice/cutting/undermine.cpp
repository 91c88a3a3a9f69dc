// Undermined skin: a flap that is free of the tissue below retracts as a strip under tension.
#include "turgor/models/lattice/cutting/undermine.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

const Exec kAll(2);
constexpr double kSpacing = 0.003, kTension = 1, kStiffness = 300, kYoung = 1e4;
constexpr int kNx = 61, kNy = 7, kNz = 6;

/// Gape of a cut across a strip that is fixed below and at both ends [m].
double gape_of_strip(double width, double depth, double cut) {
  Params params;
  params.tissue = {.law = TissueLaw::kSolid, .poisson = 0};
  params.skin = {.tension_along = kTension,
                 .tension_across = 0,
                 .stiffness = kStiffness,
                 .shear = 100,
                 .amplification = 0,
                 .direction = {1, 0, 0}};
  params.solver = {.sweeps = 20, .damping = 0};
  Block block{.size = {kNx, kNy, kNz}, .spacing = kSpacing, .young = kYoung};
  block.is_fixed = [](Int3 p) { return p.z == 0 || p.x == 0 || p.x == kNx - 1; };
  Model model = block_model(block, params);
  // the drawn skin, where gapes are measured, lies in the outermost nodes
  for (int j = 0; j < kNy; j++)
    for (int i = 0; i < kNx; i++)
      model.anatomy.hu[std::size_t(node_slot(model.anatomy.lattice, i, j, kNz - 1))] =
          std::int16_t(params.tissue.air_max);
  State state = make_state(model);
  const double x = 0.5 * (kNx - 1) * kSpacing + 0.5 * kSpacing, top = (kNz - 1) * kSpacing;
  constexpr double kHair = 1e-7;  // the ends lie on the skin
  const Incision incision{.from = {x, kHair, top},
                          .to = {x, (kNy - 1) * kSpacing - kHair, top},
                          .depth = cut,
                          .undermine = {.width = width, .depth = depth}};
  const BladePath path = lay_blade(model, state, incision).value();
  EXPECT_GT(cut_edges(model, state, path, 0, 1, 0), 0);
  for (int n = 0; n < 25; n++) step(kAll, model, state, {}, 0.1);  // long steps: no inertia
  return measure_wound(model, state, path, 0).gape_max;
}

// Each flap of width w and thickness d shortens by w T/(K + E d/4): free of the tissue below, its skin bears
// only what its tissue, which it bends from one side, can. The cut gapes by twice that more than one whose
// skin is attached.
TEST(Undermine, FlapRetractsAsStrip) {
  const double depth = 1.5 * kSpacing, cut = 2 * kSpacing;
  const double attached = gape_of_strip(0, depth, cut);
  for (const double width : {7.0, 10.0}) {
    const double w = width * kSpacing, expected = 2 * w * kTension / (kStiffness + 0.25 * kYoung * depth);
    EXPECT_NEAR(gape_of_strip(w, depth, cut) - attached, expected, 0.15 * expected) << w << " m";
  }
}

// Freed skin lets a short cut gape further and lowers the energy of the body, the more the wider the flaps.
// Cuts of the surface beside the crack tips would shorten the wound instead.
TEST(Undermine, ShortCutGapesFurther) {
  constexpr int kN = 31;
  constexpr double kH = 0.004, kTop = 9 * kH, kY = 15 * kH + 0.0007;
  Params params;
  params.tissue = {.law = TissueLaw::kSolid, .poisson = 0.45};
  params.skin = {.tension_along = 1, .tension_across = 1, .stiffness = 300};
  params.solver.sweeps = 8;
  Block block{.size = {kN, kN, 10}, .spacing = kH, .young = 5e3};
  block.is_fixed = [](Int3 p) { return p.x == 0 || p.y == 0 || p.z == 0 || p.x == kN - 1 || p.y == kN - 1; };
  Model model = block_model(block, params);
  for (int j = 0; j < kN; j++)
    for (int i = 0; i < kN; i++)
      model.anatomy.hu[std::size_t(node_slot(model.anatomy.lattice, i, j, 9))] =
          std::int16_t(params.tissue.air_max);
  double last_gape = 0, last_energy = 1;
  for (const double width : {0.0, 0.02, 0.036}) {
    State state = make_state(model);
    const Incision incision{.from = {kY - 0.019, kY, kTop},
                            .to = {kY + 0.019, kY, kTop},
                            .depth = 0.012,
                            .undermine = {.width = width, .depth = 0.008}};
    const BladePath path = lay_blade(model, state, incision).value();
    EXPECT_GT(cut_edges(model, state, path, 0, 1, 0), 0);
    for (int n = 0; n < 30; n++) step(kAll, model, state, {}, 0.05);
    const double gape = measure_wound(model, state, path, 0).gape_max, now = energy(kAll, model, state);
    EXPECT_GT(gape, 1.005 * last_gape) << width;
    EXPECT_LT(now, last_energy) << width;
    last_gape = gape, last_energy = now;
  }
}

}  // namespace
}  // namespace turgor::lattice

// Gapes of cuts that are oblique in the lattice, against finite elements that fit the blade.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "turgor/models/lattice/build/partial_cells.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);
constexpr double kMillimeter = 1e-3;

/// A cut in a slab of 72 × 72 mm under tense skin, which is held at its sides and below.
struct SlabCut {
  double length, depth, degrees;  // [mm]; direction in the lattice [°]
  double x, y;                    // its middle, from that of a cell [cells]
  double height;                  // of the skin over nodes [cells]
  double elements;                // gape by linear elements of app/curved_wound.hpp, 8 and 12 divisions [mm]

  static constexpr int kBlock = 4;
  static constexpr double kHalf = 36, kThick = 24;  // [mm]

  Vec3d along() const {
    const double a = degrees * std::numbers::pi / 180;
    return {std::cos(a), std::sin(a), 0};
  }
};

struct SlabBody {
  CtVolume ct;
  Model model;
  Vec3d middle;
};
SlabBody slab_body(const SlabCut& cut) {
  constexpr int kBlock = SlabCut::kBlock, kSide = 31 * kBlock, kUp = 9 * kBlock, kTall = kUp + 4 * kBlock;
  // scan with a skin between two layers of nodes
  SlabBody body;
  const Vec3d middle{kSide / 2.0, kSide / 2.0, kUp + cut.height * kBlock};
  body.ct.grid.size = {kSide, kSide, kTall};
  body.ct.grid.spacing = {kMillimeter, kMillimeter, kMillimeter};
  for (int k = 0; k < kTall; k++)
    body.ct.samples.insert(body.ct.samples.end(), std::size_t(kSide * kSide),
                           std::int16_t(std::lround(1000 * std::clamp(middle.z - k, 0.0, 1.0) - 1000)));
  body.middle = body.ct.grid.origin + (middle - Vec3d{0.5, 0.5, 0.5}) * kMillimeter;
  // a hundredth of the default tension, so that all laws are linear
  const Vec3d along = cut.along(), across{-along.y, along.x, 0};
  Params params;
  params.block = {kBlock, kBlock, kBlock};
  params.tissue.law = TissueLaw::kSolid;
  params.tissue.fat = params.tissue.muscle = 5e3;
  params.tissue.partial_cells = true;
  params.skin.tension_along = params.skin.tension_across = 0.45;
  params.skin.amplification = 0;
  params.skin.direction = along;
  params.solver = {.sweeps = 20, .damping = 8};
  // held along the sides of the cut's own frame
  BodyNodes nodes = classify(kTwo, body.ct, nullptr, params).value();
  const Int3 size = nodes.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const Vec3d x = (point_at(nodes.grid, Vec3d(Int3{i, j, k})) - body.middle) / kMillimeter;
        const double beside = std::max(std::abs(dot(x, along)), std::abs(dot(x, across)));
        nodes.fixed[sample_index(nodes.grid, i, j, k)] =
            beside > SlabCut::kHalf - 0.5 * kBlock || -x.z > SlabCut::kThick - 0.5 * kBlock;
      }
  body.model = assemble(kTwo, nodes, nullptr, params).value();
  return body;
}

double gape_of(const SlabCut& cut) {
  const SlabBody body = slab_body(cut);
  State state = make_state(body.model);
  const Vec3d at = body.middle + Vec3d{cut.x, cut.y, 0} * (SlabCut::kBlock * kMillimeter),
              reach = cut.along() * (0.5 * cut.length * kMillimeter);
  // depths count from the outermost nodes
  const double depth = (cut.depth - cut.height * SlabCut::kBlock) * kMillimeter;
  const BladePath path =
      lay_blade(body.model, state, {.from = at - reach, .to = at + reach, .depth = depth}).value();
  cut_edges(body.model, state, path, 0, 1, 0);
  for (int n = 0; n < 30; n++) step(kTwo, body.model, state, {}, 1.0 / 30);
  const BodySurface surface = build_surface(body.model, state.cuts, &body.ct, Extent::kCuts);
  return measure_wound(body.model, state, surface, path, 0).gape_max;
}

// Cuts of six to nine cells gape as finite elements do, in any direction and position.
TEST(ObliqueCuts, GapeAsFiniteElements) {
  for (const SlabCut& cut : {SlabCut{24, 8, 17.2, 0.76, 0.63, 0.7, 0.06104},
                             {24, 8, 20, 0.13, 0.62, 0.7, 0.06104},
                             {24, 8, 35, 0.13, 0.62, 0.3, 0.06111},
                             {24, 8, 39.3, 0.09, 1, 0.7, 0.06104},
                             {24, 8, 70, 0.13, 0.62, 0.3, 0.06111},
                             {30, 12, 33.9, 0.74, 0.37, 0.7, 0.06993},
                             {36, 10, 0, 0.37, 0.37, 0.3, 0.07607},
                             {36, 10, 8.5, 0.93, 0.31, 0.7, 0.07593}}) {
    const double gape = gape_of(cut) / kMillimeter;
    std::printf("%2.0f mm at %4.1f degrees: %+.1f %%\n", cut.length, cut.degrees,
                100 * (gape / cut.elements - 1));
    EXPECT_NEAR(gape, cut.elements, 0.05 * cut.elements) << "mm, a cut at " << cut.degrees << " degrees";
  }
}

}  // namespace
}  // namespace turgor::lattice

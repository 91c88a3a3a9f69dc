// Expected error of a gape in partial cells, against finite elements that fit the blade.
#include "turgor/sim/report/gape_error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "app/wound_elements.hpp"
#include "turgor/models/lattice/build/partial_cells.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor {
namespace {

constexpr double kVoxelOfSlab = 1e-3, kYoungOfSlab = 5e3;                                // [m] [Pa]
constexpr double kHalfOfSlab = 42, kHeightOfSlab = 24, kCutLength = 30, kCutDepth = 12;  // [mm]

/// Cells of `block` voxels, skin `offset` spacings above a node, and a cut in a direction [°].
struct WoundedSlab {
  int block = 4;
  double offset = 0, degrees = 0;
};

struct GapeOfSlab {
  double gape = 0, expected_error = 0;
};
GapeOfSlab gape_of_slab(const WoundedSlab& slab) {
  // CT of a slab with level skin; its middle is above a node
  const int b = slab.block, side = (2 * int(std::ceil(0.75 * kHalfOfSlab * 2 / b)) + 6) * b,
            up = (int(std::ceil(kHeightOfSlab / b)) + 3) * b, tall = up + 5 * b;
  const Vec3d middle{(side + b) / 2.0, (side + b) / 2.0, up + (0.5 + slab.offset) * b};
  CtVolume ct;
  ct.grid.size = {side, side, tall};
  ct.grid.spacing = {kVoxelOfSlab, kVoxelOfSlab, kVoxelOfSlab};
  for (int k = 0; k < tall; k++) {
    const double filled = std::clamp(middle.z - k, 0.0, 1.0);
    ct.samples.insert(ct.samples.end(), std::size_t(side) * std::size_t(side),
                      std::int16_t(std::lround(1000 * filled - 1000)));
  }
  // tissue, fixed at the sides of a square along the cut and below
  const double angle = slab.degrees * std::numbers::pi / 180;
  const Vec3d along{std::cos(angle), std::sin(angle), 0}, across{-along.y, along.x, 0};
  lattice::Params params;
  params.block = {b, b, b};
  params.tissue.law = lattice::TissueLaw::kSolid;
  params.tissue.fat = params.tissue.muscle = kYoungOfSlab;
  params.tissue.partial_cells = true;
  params.skin.direction = along;
  params.solver = {.sweeps = 20, .damping = 8};
  const Exec exec(2);
  lattice::BodyNodes nodes = lattice::classify(exec, ct, nullptr, params).value();
  const Vec3d origin = ct.grid.origin + (middle - Vec3d{0.5, 0.5, 0.5}) * kVoxelOfSlab;
  for (int k = 0; k < nodes.grid.size.z; k++)
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const Vec3d at = nodes.grid.origin + hadamard(Vec3d(Int3{i, j, k}), nodes.grid.spacing),
                    x = (at - origin) / kVoxelOfSlab;
        const double beside = std::max(std::abs(dot(x, along)), std::abs(dot(x, across)));
        nodes.fixed[sample_index(nodes.grid, i, j, k)] =
            beside > kHalfOfSlab - 0.5 * b + 0.01 || -x.z > kHeightOfSlab - 0.5 * b;
      }
  const lattice::Model model = lattice::assemble(exec, nodes, nullptr, params).value();
  // cut
  lattice::State state = make_state(model);
  const Vec3d at = origin + across * (0.37 * b * kVoxelOfSlab),
              reach = along * (0.5 * kCutLength * kVoxelOfSlab);
  const lattice::BladePath path =
      lay_blade(model, state, {.from = at - reach, .to = at + reach, .depth = kCutDepth * kVoxelOfSlab})
          .value();
  cut_edges(model, state, path, 0, 1, 0);
  for (int n = 0; n < 40; n++) step(exec, model, state, {}, 1.0 / 30);
  const lattice::BodySurface surface = build_surface(model, state.cuts, &ct, lattice::Extent::kCuts);
  return {measure_wound(model, state, surface, path, 0).gape_max,
          expected_gape_error_of_partial_cells(model.anatomy, path_length(path), kCutDepth * kVoxelOfSlab)};
}

/// Gape by finite elements, extrapolated linearly from two meshes.
double gape_of_fitted_elements() {
  const lattice::SkinParams skin;
  const CutBlock block{.side = 2 * kHalfOfSlab * kVoxelOfSlab,
                       .height = kHeightOfSlab * kVoxelOfSlab,
                       .length = kCutLength * kVoxelOfSlab,
                       .depth = kCutDepth * kVoxelOfSlab,
                       .young = kYoungOfSlab,
                       .poisson = lattice::TissueParams{}.poisson,
                       .tension = skin.tension_along,
                       .stiffness = skin.stiffness,
                       .shear = skin.shear,
                       .amplification = skin.amplification};
  const double coarse = gape_of_elements(block, 4), fine = gape_of_elements(block, 6);
  return fine + 2 * (fine - coarse);
}

// The estimate covers the errors of cuts in several directions, with the skin anywhere between two nodes. It
// is at most four times the largest of them.
TEST(GapeError, CoversErrorOfPartialCells) {
  const double exact = gape_of_fitted_elements();
  for (const int block : {4, 5}) {
    double largest = 0, expected = 0;
    for (const auto& [offset, degrees] : {std::pair{0.15, 0.0}, {0.75, 45.0}, {0.4, 20.0}}) {
      const GapeOfSlab found = gape_of_slab({block, offset, degrees});
      const double error = std::abs(found.gape / exact - 1);
      std::printf("cells of %d mm, %.0f degrees: gape %.3f of %.3f mm, error %.1f %%, expected %.1f %%\n",
                  block, degrees, 1e3 * found.gape, 1e3 * exact, 100 * error, 100 * found.expected_error);
      EXPECT_LE(error, found.expected_error);
      largest = std::max(largest, error), expected = std::max(expected, found.expected_error);
    }
    EXPECT_LE(expected, 4 * largest) << block;
  }
}

// Cuts that are too short or too shallow for their cells have no estimate.
TEST(GapeError, NeedsLengthAndDepth) {
  lattice::Anatomy anatomy;
  anatomy.lattice.spacing = {Real(0.004), Real(0.004), Real(0.003)};
  EXPECT_NEAR(expected_gape_error_of_partial_cells(anatomy, 0.028, 0.01), 0.05, 1e-6);
  EXPECT_NEAR(expected_gape_error_of_partial_cells(anatomy, 0.06, 0.01), 0.04, 1e-6);
  EXPECT_LT(expected_gape_error_of_partial_cells(anatomy, 0.02, 0.01), 0);
  EXPECT_LT(expected_gape_error_of_partial_cells(anatomy, 0.06, 0.005), 0);
}

}  // namespace
}  // namespace turgor

// Excised pieces in skin that is tilted against the lattice.
#include "turgor/models/lattice/cutting/excision.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/build/turned_block.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"

namespace turgor::lattice {
namespace {

/// Values of a CT at the nodes: two classes, or the mean of a sharp border over a node's box.
enum class Values : std::uint8_t { kClasses, kMeans };

/// A block whose top is tilted, about an axis that is not one of the lattice. The frame of its top is x, y
/// and the normal.
struct TiltedBlock {
  Vec3d x, y;
  Model model;

  TiltedBlock(double tilt, double azimuth, Values values) {
    const double t = tilt * std::numbers::pi / 180, a = azimuth * std::numbers::pi / 180;
    const Vec3d normal{std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), std::cos(t)};
    x = normalized(cross(Vec3d{0, 1, 0.2}, normal)), y = cross(normal, x);
    Params params = solid_params(1e4, 4, 0);
    params.skin.direction = x;
    const RotatedBlock block{.side = 0.09,
                             .height = 0.03,
                             .spacing = 0.004,
                             .young = 1e4,
                             .rotation = {{x, y, normal}},
                             .top = 0.0007};
    BodyNodes nodes = rotated_nodes(block);
    if (values == Values::kMeans)
      for (std::size_t n = 0; n < nodes.hu.size(); n++) nodes.hu[n] = mean_hu(block, nodes.grid, n);
    model = assemble(Exec(1), std::move(nodes), nullptr, params).value();
  }

  /// A ramp over one spacing that has the threshold of air at the top of the block.
  static std::int16_t mean_hu(const RotatedBlock& block, const Grid& grid, std::size_t n) {
    const auto i = int(n) % grid.size.x, j = int(n) / grid.size.x % grid.size.y,
               k = int(n) / (grid.size.x * grid.size.y);
    const double height = block.in_block(grid, {i, j, k}).z - block.top;
    return std::int16_t(
        std::clamp(TissueParams{}.air_max - 1000 * height / block.spacing, double(kAirHu), 0.0));
  }
};

constexpr double kLength = 0.05, kWidth = 0.02, kDepth = 0.01;

/// Area of a lens between two arcs [m²].
double lens_area() {
  const double radius = (kLength * kLength + kWidth * kWidth) / (4 * kWidth),
               half = std::asin(kLength / (2 * radius));
  return radius * radius * (2 * half - std::sin(2 * half));
}

/// Volume of an excised lens over its area times its depth.
double excised_volume(const TiltedBlock& block, double angle) {
  State state = make_state(block.model);
  const Excision lens{.center = 0.0013 * block.x + 0.0007 * block.y,
                      .direction = block.x,
                      .angle = angle,
                      .length = kLength,
                      .width = kWidth};
  Incision blade{.name = "mole", .depth = kDepth};
  blade.path = excision_outline(block.model, state, lens).value(), blade.excision = lens;
  const BladePath path = lay_blade(block.model, state, blade).value();
  cut_edges(block.model, state, path, 0, 1, 0);
  const Result<FreePiece> piece = find_piece(block.model, state.cuts, 0);
  EXPECT_TRUE(piece) << angle << " degrees: " << piece.error().message;
  return piece ? mass_of(block.model, state.cuts, *piece).volume / (lens_area() * kDepth) : 0;
}

void expect_volume_of_lens(double tilt, double azimuth, Values values, std::array<double, 2> angles) {
  const TiltedBlock block(tilt, azimuth, values);
  for (const double angle : angles) {
    const double volume = excised_volume(block, angle);
    std::printf("  tilt %2.0f, lens at %3.0f degrees: %.3f of area times depth\n", tilt, angle, volume);
    EXPECT_NEAR(volume, 1, 0.05) << tilt << ", " << angle << " degrees";
  }
}

// A lens comes free in any direction on tilted skin, with its area times the depth below the skin of the CT.
TEST(Excision, PieceHasVolumeOfLensOnTiltedSkin) {
  expect_volume_of_lens(7, 35, Values::kClasses, {0, 75});
  expect_volume_of_lens(15, 0, Values::kClasses, {30, 120});
  expect_volume_of_lens(30, 35, Values::kClasses, {0, 75});
  expect_volume_of_lens(30, 35, Values::kMeans, {30, 120});
}

}  // namespace
}  // namespace turgor::lattice

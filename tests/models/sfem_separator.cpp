#include <numeric>

#include <gtest/gtest.h>

#include "tests/models/sfem_bodies.hpp"
#include "turgor/models/sfem/separator.hpp"

namespace turgor::sfem {
namespace {

constexpr Sides kSides{5, 6, 7};

/// A block of 6 × 6 × 11 free nodes whose ends are the sides and whose middle, three layers, is between.
struct Halves {
  Model model =
      build(Exec(1), block_of(hex_block({1, 1, 2.2}, {5, 5, 11}), {1, 0.3}, [](Vec3d x) { return x.z == 0; }),
            {})
          .value();
  std::vector<int> part, side;
  std::vector<std::uint8_t> is_settled;

  Halves() : part(model.vertex.size()), side(part.size()), is_settled(part.size(), 0) {
    std::iota(part.begin(), part.end(), 0);
    for (std::size_t row = 0; row < part.size(); row++) {
      const double z = model.body.mesh.vertices[std::size_t(model.vertex[row])].z;
      side[row] = z < 0.9 ? kSides.low : z > 1.5 ? kSides.high : kSides.between;
    }
  }
};

TEST(SfemSeparator, three_layers_between_the_sides_become_one) {
  Halves h;
  EXPECT_EQ(std::count(h.side.begin(), h.side.end(), kSides.between), 3 * 36);
  EXPECT_EQ(refine_separator(h.model.stiffness, h.part, kSides, h.side, h.is_settled), 36u);
  EXPECT_EQ(std::count(h.side.begin(), h.side.end(), kSides.between), 36);
  for (const int row : h.part)
    for (const int other : neighbours(h.model.stiffness, row))
      EXPECT_FALSE(h.side[std::size_t(row)] == kSides.low && h.side[std::size_t(other)] == kSides.high);
  EXPECT_EQ(std::count(h.is_settled.begin(), h.is_settled.end(), 1), 0);
}

TEST(SfemSeparator, neither_side_grows_beyond_its_share) {
  Halves h;
  refine_separator(h.model.stiffness, h.part, kSides, h.side, h.is_settled);
  for (const int side : {kSides.low, kSides.high})
    EXPECT_LE(std::count(h.side.begin(), h.side.end(), side), std::ptrdiff_t(0.6 * double(h.part.size())));
}

TEST(SfemSeparator, nodes_of_other_parts_are_left_alone) {
  Halves h;
  std::vector<int> rest;
  for (const int row : h.part)
    if (row % 6 == 0) {
      h.side[std::size_t(row)] = 99;
    } else {
      rest.push_back(row);
    }
  EXPECT_EQ(refine_separator(h.model.stiffness, rest, kSides, h.side, h.is_settled), 30u);
  EXPECT_EQ(std::count(h.side.begin(), h.side.end(), 99), 66);
}

}  // namespace
}  // namespace turgor::sfem

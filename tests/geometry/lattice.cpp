#include "turgor/geometry/lattice.hpp"

#include <set>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Node slots are unique and map back to their node.
TEST(Lattice, SlotsMapToUniqueNodes) {
  const Lattice l = make_lattice({7, 5, 4}, {1, 1, 1});
  std::set<int> slots;
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 5; j++)
      for (int i = 0; i < 7; i++) {
        const int slot = node_slot(l, i, j, k);
        EXPECT_TRUE(slots.insert(slot).second);
        EXPECT_EQ(slot_node(l, slot), (Int3{i, j, k}));
        EXPECT_LT(slot, slot_count(l));
      }
}

// A slot plus a family's offset is the slot of the neighbor.
TEST(Lattice, SlotOffsetsReachNeighbors) {
  const Lattice l = make_lattice({6, 5, 4}, {1, 1, 1});
  for (int k = 1; k < 3; k++)
    for (int j = 1; j < 4; j++)
      for (int i = 1; i < 5; i++)
        for (const Int3 family : kFamilies)
          for (const Int3 offset : {family, -family})
            EXPECT_EQ(node_slot(l, i, j, k) + slot_offset(l, offset, i & 1),
                      node_slot(l, Int3{i, j, k} + offset));
}

// Neighbors beyond the border have padding slots, which hold no node.
TEST(Lattice, BorderNeighborsHavePaddingSlots) {
  const Lattice l = make_lattice({7, 3, 3}, {1, 1, 1});
  std::set<int> nodes;
  for (int n = 0; n < node_count(l); n++) nodes.insert(node_slot(l, n % 7, n / 7 % 3, n / 21));
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++)
      for (int i = 0; i < 7; i++)
        for (const Int3 family : kFamilies)
          for (const Int3 offset : {family, -family}) {
            const int slot = node_slot(l, i, j, k) + slot_offset(l, offset, i & 1);
            EXPECT_GE(slot, 0);
            EXPECT_LT(slot, slot_count(l));
            EXPECT_EQ(nodes.contains(slot), contains(l, Int3{i, j, k} + offset));
          }
}

// The six Kuhn tetrahedra fill a cell; their edges are the seven families.
TEST(Lattice, SixKuhnTetrahedraFillCell) {
  double volume = 0;
  for (const auto& tet : kKuhnTets) {
    const Vec3d a(tet[0]), b(tet[1]), c(tet[2]), d(tet[3]);
    const double v = dot(b - a, cross(c - a, d - a)) / 6;
    EXPECT_NEAR(v, 1.0 / 6, 1e-15);
    volume += v;
    for (int p = 0; p < 4; p++)
      for (int q = p + 1; q < 4; q++) {
        const Int3 e = tet[std::size_t(q)] - tet[std::size_t(p)];
        EXPECT_TRUE(family_of(e) >= 0 || family_of(-e) >= 0);
      }
  }
  EXPECT_NEAR(volume, 1, 1e-15);
}

}  // namespace
}  // namespace turgor

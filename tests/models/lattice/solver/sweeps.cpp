// Nodes that a sweep processes at once are independent.
#include "turgor/models/lattice/solver/sweeps.hpp"

#include <set>

#include <gtest/gtest.h>

#include "turgor/models/lattice/build/springs.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {
namespace {

// No two slabs of a phase share a node.
TEST(LatticeSweeps, SlabsOfPhaseShareNoNodes) {
  for (const int layers : {2, 3, 7, 12}) {
    for (int phase = 0; phase < 2; phase++) {
      std::set<int> touched;
      for (int slab = phase; slab < slab_count({0, layers}); slab += 2) {
        std::set<int> nodes;  // layers that the slab writes: its own and, for edges and cells, the next one
        for (int k = slab * kSlabLayers; k < (slab + 1) * kSlabLayers && k < layers; k++)
          nodes.insert({k, k + 1});
        for (const int k : nodes) EXPECT_TRUE(touched.insert(k).second) << "layer " << k << " of " << layers;
      }
    }
  }
}

// No two lanes of a row pass share a node.
TEST(LatticeSweeps, LanesOfRowPassShareNoNodes) {
  for (const int nx : {2, 3, 8, 9, 33}) {
    const Lattice l = make_lattice({nx, 4, 4}, {1, 1, 1});
    for (const auto& family : kFamilies)
      for (int parity = 0; parity < 2; parity++) {
        std::set<int> slots;
        const int a = row_slot(l, 1, 1) + parity * l.half, b = a + slot_offset(l, family, parity);
        for (int i = 0; i < half_count(l, parity); i++) {
          EXPECT_TRUE(slots.insert(a + i).second);
          EXPECT_TRUE(slots.insert(b + i).second) << "family " << family.x << family.y << family.z;
        }
      }
    for (const auto& tet : kKuhnTets)
      for (int parity = 0; parity < 2; parity++) {
        std::set<int> slots;
        for (const Int3 corner : tet)
          for (int i = 0; i < half_count(l, parity); i++)
            EXPECT_TRUE(slots.insert(row_slot(l, 1, 1) + parity * l.half + slot_offset(l, corner, parity) + i)
                            .second);
      }
  }
}

}  // namespace
}  // namespace turgor::lattice

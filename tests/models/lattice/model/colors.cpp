// Sweeps by colors: the updates of a pass are independent, so that GPU threads may run them in any order.
#include "turgor/models/lattice/model/colors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;

// No two cells of a color share a node.
TEST(LatticeColors, CellsOfColorShareNoNodes) {
  for (const Int3 size : {Int3{9, 8, 7}, {12, 5, 4}, {2, 2, 2}, {33, 3, 6}})
    for (int color = 0; color < kColorCount; color++) {
      const Lattice l = make_lattice(size, {1, 1, 1});
      const ColorRows rows(size, color);
      std::set<int> touched;  // by edges and tetrahedra of the cells, also beyond the border
      for (std::size_t n = 0; n < rows.count(); n++) {
        const auto [parity, j, k] = rows[n];
        for (int i = parity; i < size.x; i += 2) {
          EXPECT_EQ(color_of({i, j, k}), color);
          for (int corner = 0; corner < 8; corner++)
            EXPECT_TRUE(touched
                            .insert(node_slot(l, {i, j, k}) +
                                    slot_offset(l, {corner & 1, corner >> 1 & 1, corner >> 2}, parity))
                            .second)
                << i << " " << j << " " << k;
        }
      }
    }
}

// The half rows of all colors cover every node once.
TEST(LatticeColors, HalfRowsCoverNodesOnce) {
  const Int3 size{13, 6, 5};
  std::set<std::array<int, 3>> seen;
  for (int color = 0; color < kColorCount; color++) {
    const ColorRows rows(size, color);
    for (std::size_t n = 0; n < rows.count(); n++) {
      EXPECT_TRUE(seen.insert({rows[n].parity, rows[n].j, rows[n].k}).second);
      EXPECT_TRUE(contains(make_lattice(size, {1, 1, 1}), {rows[n].parity, rows[n].j, rows[n].k}));
    }
  }
  EXPECT_EQ(seen.size(), std::size_t(2 * size.y * size.z));
}

// Any order of updates within a color gives the same bits.
TEST(LatticeColors, AnyOrderWithinColorEqualBits) {
  for (const Method method : {Method::kPbd, Method::kVbd}) {
    std::set<std::uint64_t> hashes;
    const auto hash_after = [&](const auto& sweep) {
      auto [model, state] = cut_block(method);
      predict(kOne, model, state, {}, kDt);
      for (int n = 0; n < 4; n++) sweep(model, state, n % 2 ? Order::kBackward : Order::kForward);
      hashes.insert(state_hash(model, state));
    };
    hash_after([&](const Model& model, State& state, Order order) {
      method == Method::kPbd ? sweep_pbd(kOne, model, state) : sweep_vbd(kOne, model, state, {}, kDt, order);
    });
    for (const unsigned seed : {1u, 2u, 3u})
      hash_after([&](const Model& model, State& state, Order order) {
        const ShuffledRun run{seed};
        method == Method::kPbd ? sweep_pbd_by_colors(run, model, state)
                               : sweep_vbd_by_colors(run, model, state, {}, kDt, order);
      });
    EXPECT_EQ(hashes.size(), 1u) << "method " << int(method);
  }
}

/// Force at rest of a plate that presses the whole top of a block by 1 mm [N].
double plate_force(Ordering ordering, TissueLaw law) {
  const Int3 size{9, 12, 7};
  Params params;
  params.tissue = {.law = law, .poisson = 0.4};
  params.solver = {.ordering = ordering, .sweeps = 10, .damping = 8};
  const Model model = block_model({.size = size, .is_fixed = [](Int3 p) { return p.z == 0; }}, params);
  std::vector<NodeContact> contacts;
  for (int j = 0; j < size.y; j++)
    for (int i = 0; i < size.x; i++)
      contacts.push_back({.slot = node_slot(model.anatomy.lattice, i, j, size.z - 1),
                          .normal = {0, 0, -1},
                          .target = {0, 0, -1e-3f}});
  std::sort(contacts.begin(), contacts.end(),
            [](const NodeContact& a, const NodeContact& b) { return a.slot < b.slot; });
  State state = make_state(model);
  for (int n = 0; n < 150; n++) step(Exec(2), model, state, {.contacts = contacts}, kDt);
  double force = 0;
  for (const NodeContact& c : contacts) force -= double(c.force.z);
  return force;
}

// The force on a plate is the same by slabs and by colors.
TEST(LatticeColors, PlateForceMatchesSlabs) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    const double slabs = plate_force(Ordering::kSlabs, law), colors = plate_force(Ordering::kColors, law);
    std::printf("  law %d: %.5f N by slabs, %.5f N by colors\n", int(law), slabs, colors);
    EXPECT_GT(slabs, 0.1) << "N";
    EXPECT_NEAR(colors, slabs, 1e-3 * slabs) << "N, law " << int(law);
  }
}

}  // namespace
}  // namespace turgor::lattice

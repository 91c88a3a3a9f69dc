// A block with blades in it, for tests of lattice steps by colors on the host and on devices.
#pragma once

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

struct CutBlock {
  Model model;
  State state;
};
/// A tense, displaced and cut block with fixed sides.
inline CutBlock cut_block(Method method, Int3 size = {13, 11, 9}, bool volumes = true,
                          TissueLaw law = TissueLaw::kSprings, SkinLaw skin = SkinLaw::kFiber) {
  const auto is_side = [size](Int3 p) {
    return p.x == 0 || p.y == 0 || p.z == 0 || p.x == size.x - 1 || p.y == size.y - 1;
  };
  Params params;
  params.solver = {.method = method, .ordering = Ordering::kColors, .pbd_volume = volumes};
  params.tissue = {.law = law, .volume = method == Method::kVbd && volumes ? 1.0 : 0.0};
  params.skin.law = method == Method::kPbd ? SkinLaw::kArea : skin;
  params.skin.stiffening = params.skin.fiber_stiffening = 1;  // the displacements are large
  CutBlock block{block_model({.size = size, .is_fixed = is_side}, params), {}};
  block.state = make_state(block.model);
  const auto wave = [](int a, int b) { return Real(1e-3 * std::sin(1.3 * a + 0.7 * b)); };
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        if (!is_side({i, j, k}))
          block.state.motion.u.set(std::size_t(node_slot(block.model.anatomy.lattice, i, j, k)),
                                   {wave(i, j), wave(j, k), wave(k, i)});
  const double y = 0.004 * (size.y / 2 + 0.5), z = 0.004 * (size.z - 1);
  const BladePath path =
      lay_blade(block.model, block.state, {.from = {0.015, y, z}, .to = {0.032, y, z}}).value();
  EXPECT_GT(cut_edges(block.model, block.state, path, 0, 1, 0), 10);
  return block;
}

/// Largest difference of displacements and largest displacement [m].
struct StateDifference {
  double most = 0, largest = 0;
};
inline StateDifference state_difference(const Model& model, const State& a, const State& b) {
  StateDifference found;
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++) {
    found.most = std::max(found.most, norm(Vec3d(a.motion.u[s]) - Vec3d(b.motion.u[s])));
    found.largest = std::max(found.largest, norm(Vec3d(a.motion.u[s])));
  }
  return found;
}

/// Contacts of a finger on some nodes of the top, and one contact between two nodes.
inline std::vector<NodeContact> finger(const Model& model) {
  const int z = model.anatomy.lattice.size.z - 2;  // a layer of air above
  std::vector<NodeContact> contacts;
  for (int i = 3; i < 8; i++)
    contacts.push_back({.slot = node_slot(model.anatomy.lattice, i, 4, z),
                        .normal = {0, 0, -1},
                        .target = {0, 0, -2e-3f},
                        .friction = 0.3f,
                        .is_held = i == 5});
  contacts.push_back(contacts[0]);
  contacts.back().other = node_slot(model.anatomy.lattice, 4, 4, z);
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const NodeContact& a, const NodeContact& b) { return a.slot < b.slot; });
  return contacts;
}

}  // namespace turgor::lattice

// Block of one tissue, made node by node for tests and validation. With skin, it has a layer of air above.
#pragma once

#include <functional>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

struct Block {
  Int3 size;                // nodes of tissue
  double spacing = 0.004;   // [m]
  double young = 5e3;       // [Pa]
  bool skin_on_top = true;  // a layer of outside air above
  std::function<bool(Int3)> is_fixed = [](Int3) { return false; };
};

inline BodyNodes block_nodes(const Block& block) {
  // grid and constant fields
  BodyNodes nodes;
  nodes.grid.size = block.size + Int3{0, 0, block.skin_on_top ? 1 : 0};
  nodes.grid.spacing = {block.spacing, block.spacing, block.spacing};
  const std::size_t count = sample_count(nodes.grid);
  nodes.hu.assign(count, 0);
  nodes.tissue.assign(count, Tissue::kMuscle);
  nodes.young.assign(count, float(block.young));
  nodes.fixed.assign(count, 0);
  // air above, fixed nodes
  for (int k = 0; k < nodes.grid.size.z; k++)
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, k);
        if (k == block.size.z) {
          nodes.tissue[n] = Tissue::kOutside;
          nodes.hu[n] = kAirHu;
          nodes.young[n] = 0;
        } else {
          nodes.fixed[n] = block.is_fixed({i, j, k});
        }
      }
  return nodes;
}

inline Model block_model(const Block& block, Params params) {
  params.skin.enabled = params.skin.enabled && block.skin_on_top;
  return assemble(Exec(1), block_nodes(block), nullptr, params).value();
}

}  // namespace turgor::lattice

// From a CT to the nodes of a body: what every node is made of, how stiff it is, and whether it may move.
#pragma once

#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {

/// One value a node, i fastest.
struct BodyNodes {
  Grid grid;
  std::vector<std::int16_t> hu;  // mean of the block around the node [HU]
  std::vector<Tissue> tissue;
  std::vector<float> young;         // Young's modulus; 0 outside [Pa]
  std::vector<std::uint8_t> fixed;  // 1 = never moves
};

/// What lies beside the body, as the table, becomes air; mean of each node's block, the outside by flood fill
/// from the sides, the largest connected rest as the body, tissues by Hounsfield units. [STC 4.1.1]
Result<BodyNodes> classify(const Exec& exec, const CtVolume& ct, const LabelVolume* labels,
                           const Params& params);

/// Masses, springs and skin for nodes that are already known. `lines` may be null.
Result<Model> assemble(const Exec& exec, const BodyNodes& nodes, const VectorVolume* lines,
                       const Params& params);

}  // namespace turgor::lattice

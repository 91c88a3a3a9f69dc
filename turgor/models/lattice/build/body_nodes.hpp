// From a CT to the nodes of a body: what every node is made of, how stiff it is, and whether it may move.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "turgor/models/lattice/build/surroundings.hpp"

namespace turgor::lattice {

/// A triangle of skin by its nodes' numbers in the body (number_in_body).
using SkinNodes = std::array<std::int64_t, 3>;
/// Triangles of a part's own layers become those of the whole body, in the order of layers.
using JoinSkin = std::function<void(std::vector<SkinNodes>&)>;

/// One value a node, i fastest.
struct BodyNodes {
  Grid grid;
  std::vector<std::int16_t> hu;  // mean of the block around the node [HU]
  std::vector<Tissue> tissue;
  std::vector<float> young;         // Young's modulus; 0 outside [Pa]
  std::vector<std::uint8_t> fixed;  // 1 = never moves

  // Of a part of a body (halo.hpp): the body's layers before it, and its own ones; empty: it is the whole.
  // `grid` has the part's size and the whole's origin.
  int first = 0;
  Layers owned;
  JoinSkin join_skin;
};

// The steps of classify, for those who have only a part of a CT:
/// Nodes of a CT, one between so many voxels.
Grid node_grid(const Grid& ct, Int3 block);
/// The slices that go into the means of these layers of nodes.
Layers slices_around(const Grid& ct, Int3 block, Layers layers);
/// Mean of each node's block, i fastest; `nodes` are those of the whole CT [HU].
std::vector<std::int16_t> average_blocks(const Exec& exec, const CtPart& ct, const Surroundings& beside,
                                         const Params& params, const Grid& nodes, Layers layers);
/// What nodes are made of, from `hu` and where outside is; `layers`: of the whole's, of which there are
/// `count`.
void name_tissues(const Exec& exec, const std::vector<std::uint8_t>& outside, const Params& params, int first,
                  int count, BodyNodes& nodes);
/// Is a node of a layer at an end of the scan along an axis? `size`: of the whole.
inline bool is_at_end(Int3 p, Int3 size, int axis) { return p[axis] == 0 || p[axis] == size[axis] - 1; }

/// What lies beside the body, as the table, becomes air; mean of each node's block, the outside by flood fill
/// from the sides, the largest connected rest as the body, tissues by Hounsfield units. [STC 4.1.1]
Result<BodyNodes> classify(const Exec& exec, const CtVolume& ct, const LabelVolume* labels,
                           const Params& params);

/// Masses, springs and skin for nodes that are already known. `lines` may be null. Error: no skin, though it
/// is asked for; a part of a body may have none.
Result<Model> assemble(const Exec& exec, const BodyNodes& nodes, const VectorVolume* lines,
                       const Params& params);

}  // namespace turgor::lattice

// Cells that the body fills in part. The nodes of a body are the block means above the level of air, so the
// cells whose corners are all body end up to a step inside its surface, and what is beyond would weigh but
// not bear. Every cell that has a body corner is therefore an element in proportion to its body voxels, with
// its one integration point at their center. This is the finite cell method [Parvizian, Düster, Rank 2007]
// with one point a cell, and a least fraction where the body fills almost nothing.
#pragma once

#include <functional>

#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/build/cell_surface.hpp"

namespace turgor::lattice {

/// Least fraction of a cell, α of the finite cell method. Without it, almost no tissue would hold the nodes
/// of a cell that the body barely enters.
constexpr double kLeastFraction = 0.05;

/// Voxels of a cell. Positions count in half voxels from the center of the cell, so that sums are exact.
struct CellVoxels {
  std::int32_t all = 0;                               // voxels of the scan in the cell
  std::int32_t body = 0;                              // those above the level of air, without surroundings
  std::array<std::int32_t, 3> sum_all{}, sum_body{};  // sums of positions [half voxels]
};

/// Counts the voxels of a cell, given by its lowest node in the whole body. The slab must hold its slices.
CellVoxels count_voxels(const CtSlab& ct, const Surroundings& surroundings, double air_max, Int3 block,
                        Int3 cell);
/// Voxels of a cell, by its lowest node.
using VoxelsOfCell = std::function<CellVoxels(Int3)>;

/// Finds the partial cells and fills `nodes.fill`. Nodes outside that are corners of a partial cell become
/// rim nodes: they get the mean modulus of the nearest body nodes. Cells next to gas inside the body are as
/// without this function. In a process with some layers of a body, the four outermost layers are incomplete
/// (kLayersForPartialCells).
void find_partial_cells(const Exec& exec, const VoxelsOfCell& voxels, Int3 block, BodyNodes& nodes);

/// Finds the surface in the cells that have body and other corners (BodyNodes::surface), except next to gas.
void find_surfaces(const Exec& exec, const CrossingOfEdge& crossing, BodyNodes& nodes);

/// Layers of nodes on each side that determine the partial cells of a layer.
constexpr int kLayersForPartialCells = 4;

/// Marks of fixed nodes, BodyNodes::fixed, with rim nodes: one is fixed if all nearest body nodes are.
std::vector<std::uint8_t> fixed_with_rim(const Exec& exec, const BodyNodes& nodes);

}  // namespace turgor::lattice

// Nodes of a body from a CT: tissue, stiffness, and fixed nodes. Assembly of the model is in build.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "turgor/core/result.hpp"
#include "turgor/models/lattice/build/cell_surface.hpp"
#include "turgor/models/lattice/build/surroundings.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

/// Skin triangle by the indices of its nodes in the whole body (number_in_body).
using SkinNodes = std::array<std::int64_t, 3>;
/// Gathers the triangles of the owned layers of all processes, in the order of layers.
using JoinSkin = std::function<void(std::vector<SkinNodes>&)>;

/// One value per node, i fastest.
struct BodyNodes {
  Grid grid;
  std::vector<std::int16_t> hu;  // mean of the block around the node [HU]
  std::vector<Tissue> tissue;
  std::vector<float> young;          // Young's modulus; outside: 0, or that of a rim node [Pa]
  std::vector<std::uint8_t> fixed;   // 1 = fixed
  CellFill fill;                     // of cells at the surface (partial_cells.hpp)
  std::vector<CellSurface> surface;  // with partial cells: of the cells that contain it, in lattice order
  std::vector<std::uint16_t> label;  // of a segmentation; empty without moduli by label
  std::vector<RegionShare> regions;  // of the cells, in lattice order (regions.hpp)
  Surroundings surroundings;         // in the CT

  // Only for a process with some layers of a body (halo.hpp): number of layers of the body before it, and its
  // owned layers. `grid` has the size of these layers and the origin of the whole. Empty: the whole body.
  int first = 0;
  Layers owned;
  JoinSkin join_skin;
};

/// True if cells at the surface bear in proportion to their filled part (TissueParams::partial_cells).
inline bool has_partial_cells(const Params& params) {
  return params.tissue.law == TissueLaw::kSolid && params.tissue.partial_cells;
}

/// Young's modulus of a node: that of its label, else that of its tissue. Fixed bone only affects the springs
/// to its neighbors; twice muscle makes them about as stiff as half a spring of tissue on a rigid wall. 0
/// outside.
float modulus_of_node(Tissue tissue, int label, const Params& params);

// Steps of classify, for a process with some slices of a CT:
/// Grid of the nodes of a CT: one node at each corner of the voxel blocks.
Grid node_grid(const Grid& ct, Int3 block);
/// CT slices that contribute to the means of these layers of nodes.
Layers slices_around(const Grid& ct, Int3 block, Layers layers);
/// Mean of the voxel block of each node, i fastest; `nodes` is the grid of the whole CT [HU].
std::vector<std::int16_t> average_blocks(const Exec& exec, const CtSlab& ct, const Surroundings& surroundings,
                                         const Params& params, const Grid& nodes, Layers layers);
/// Determines tissue, stiffness and fixed nodes from `hu` and the outside mask. The nodes begin at layer
/// `first` of a body with `count` layers.
void classify_tissues(const Exec& exec, const std::vector<std::uint8_t>& outside, const Params& params,
                      int first, int count, BodyNodes& nodes);
/// True if a node is at an end of the scan along an axis. `size`: of the whole.
inline bool is_at_end(Int3 p, Int3 size, int axis) { return p[axis] == 0 || p[axis] == size[axis] - 1; }

/// Classifies the nodes of a CT. Surroundings such as the table become air. Each node has the mean of its
/// voxel block. A flood fill from the sides finds the outside. The body is the largest remaining component,
/// and Hounsfield units give tissues. [STC 4.1.1]
Result<BodyNodes> classify(const Exec& exec, const CtVolume& ct, const LabelVolume* labels,
                           const Params& params);

/// Assembles the model from its nodes: masses, springs or cells, skin. `lines` may be null. Error: no skin
/// although skin is enabled; single processes of a distributed body may have none.
Result<Model> assemble(const Exec& exec, const BodyNodes& nodes, const VectorVolume* lines,
                       const Params& params);

}  // namespace turgor::lattice

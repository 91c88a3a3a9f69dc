// Regions of a lattice body: layers of tissue that labels of a segmentation or CT values choose
// (TissueLayer). A cell has the voxels of its block; their counts are the shares of the regions in the cell.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Shares of the regions in the cells of the nodes of a CT, in lattice order. Voxels of air that no label
/// covers do not count. A voxel that several regions contain belongs to the first of them. `labels` may be
/// null; voxels beyond its grid have no label.
std::vector<RegionShare> find_regions(const Exec& exec, const CtVolume& ct, const LabelVolume* labels,
                                      const Params& params);

}  // namespace turgor::lattice

#include "turgor/models/lattice/build/regions.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

namespace {

/// Voxels of a CT with their labels. The grids have the same axes and spacing; a crop shifts them.
struct LabeledCt {
  const CtVolume& ct;
  const LabelVolume* labels;
  Int3 shift;  // of the index in `labels`

  LabeledCt(const CtVolume& volume, const LabelVolume* of) : ct(volume), labels(of) {
    if (!labels) return;
    const Vec3d origin = index_at(labels->grid, ct.grid.origin);
    shift = {int(std::lround(origin.x)), int(std::lround(origin.y)), int(std::lround(origin.z))};
  }
  int label_of(Int3 voxel) const {
    if (!labels) return 0;
    const Int3 p = voxel + shift;
    return contains(labels->grid, p) ? labels->at(p.x, p.y, p.z) : 0;
  }
};

/// Index of the first layer that contains the voxel; −1 for none.
int region_of(const LabeledCt& ct, Int3 voxel, const std::vector<TissueLayer>& layers) {
  const int label = ct.label_of(voxel);
  const double hu = double(ct.ct.at(voxel.x, voxel.y, voxel.z));
  for (std::size_t n = 0; n < layers.size(); n++) {
    const TissueLayer& layer = layers[n];
    if (layer.label > 0 && layer.label == label) return int(n);
    if (layer.hu && hu >= (*layer.hu)[0] && hu <= (*layer.hu)[1]) return int(n);
  }
  return -1;
}

/// Adds the shares of a cell.
struct CellCounter {
  LabeledCt ct;
  const Params& params;
  Grid nodes;

  void add(Int3 cell, std::vector<int>& counts, std::vector<RegionShare>& out) const {
    // voxels by region
    const Int3 block = params.block, size = ct.ct.grid.size;
    counts.assign(params.tissue.layers.size(), 0);
    int tissue = 0, found = 0;
    for (int k = cell.z * block.z; k < std::min((cell.z + 1) * block.z, size.z); k++)
      for (int j = cell.y * block.y; j < std::min((cell.y + 1) * block.y, size.y); j++)
        for (int i = cell.x * block.x; i < std::min((cell.x + 1) * block.x, size.x); i++) {
          const int region = region_of(ct, {i, j, k}, params.tissue.layers);
          tissue += region >= 0 || ct.ct.at(i, j, k) >= params.tissue.air_max;
          if (region >= 0) counts[std::size_t(region)]++, found++;
        }
    // shares
    if (found == 0) return;
    const int number = int(sample_index(nodes, cell.x, cell.y, cell.z));
    for (std::size_t n = 0; n < counts.size(); n++)
      if (counts[n] > 0) out.push_back({number, int(n), Real(counts[n]) / Real(tissue)});
  }
};

}  // namespace

std::vector<RegionShare> find_regions(const Exec& exec, const CtVolume& ct, const LabelVolume* labels,
                                      const Params& params) {
  const std::vector<TissueLayer>& layers = params.tissue.layers;
  if (std::none_of(layers.begin(), layers.end(), is_region)) return {};
  const CellCounter counter{LabeledCt(ct, labels), params, node_grid(ct.grid, params.block)};
  const Int3 size = counter.nodes.size;
  TURGOR_CHECK(size.z > 1, "a lattice has at least one layer of cells");
  std::vector<std::vector<RegionShare>> by_layer(std::size_t(size.z - 1));
  parallel_for(exec, by_layer.size(), [&](std::size_t k) {
    std::vector<int> counts;
    for (int j = 0; j + 1 < size.y; j++)
      for (int i = 0; i + 1 < size.x; i++) counter.add({i, j, int(k)}, counts, by_layer[k]);
  });
  std::vector<RegionShare> all;
  for (const std::vector<RegionShare>& layer : by_layer) all.insert(all.end(), layer.begin(), layer.end());
  return all;
}

}  // namespace turgor::lattice

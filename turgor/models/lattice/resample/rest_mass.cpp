#include "turgor/models/lattice/resample/rest_mass.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

Int3 block_of(Vec3d cell_size) {
  const Int3 block{int(std::lround(cell_size.x)), int(std::lround(cell_size.y)),
                   int(std::lround(cell_size.z))};
  TURGOR_ASSERT(norm(cell_size - Vec3d(block)) < 1e-3,
                "the body was built from this CT, in whole blocks of its voxels");
  return block;
}

/// Σ (HU + 1000) of the cells above one layer of nodes.
struct LayerMass {
  const Model& model;
  const Cuts& cuts;
  const CtVolume& ct;
  Int3 block;
  std::vector<std::int64_t>& layer_mass;

  void operator()(std::size_t layer) const {
    const Lattice& l = model.anatomy.lattice;
    std::int64_t mass = 0;
    for (int j = 0; j + 1 < l.size.y; j++) {
      int begin = 0;  // first cell of a run of whole cells
      for (int i = 0; i + 1 < l.size.x; i++) {
        const Int3 cell{i, j, int(layer)};
        const std::array<int, 8> slots = cell_slots(l, node_slot(l, cell), i & 1);
        if (is_whole(slots)) continue;
        mass += box_mass({begin, j, cell.z}, {i, j + 1, cell.z + 1}) + partial_mass(cell, slots);
        begin = i + 1;
      }
      mass += box_mass({begin, j, int(layer)}, {l.size.x - 1, j + 1, int(layer) + 1});
    }
    layer_mass[layer] = mass;
  }

  bool is_solid(int slot) const { return lattice::is_solid(model, cuts, slot); }
  /// True if all six tetrahedra are tissue; each contains the first and the last corner of the cell.
  bool is_whole(const std::array<int, 8>& slots) const {
    if (!is_solid(slots[0]) && !is_solid(slots[7])) return false;
    if (cuts.removed_nodes == 0) return true;
    return std::none_of(slots.begin(), slots.end(),
                        [&](int slot) { return cuts.removed[std::size_t(slot)] != 0; });
  }

  std::int64_t box_mass(Int3 low, Int3 high) const {
    const Int3 from = hadamard(low, block), to = min(hadamard(high, block), ct.grid.size);
    std::int64_t mass = 0;
    for (int k = from.z; k < to.z; k++)
      for (int j = from.y; j < to.y; j++) {
        const std::int16_t* row = &ct.samples[sample_index(ct.grid, 0, j, k)];
        std::int64_t sum = 0;
        for (int i = from.x; i < to.x; i++) sum += row[i] - kAirHu;
        mass += sum;
      }
    return mass;
  }

  std::int64_t partial_mass(Int3 cell, const std::array<int, 8>& slots) const {
    if (std::none_of(slots.begin(), slots.end(), [&](int slot) { return is_solid(slot); })) return 0;
    const Int3 from = hadamard(cell, block), to = min(from + block, ct.grid.size);
    std::int64_t mass = 0;
    // voxels whose centers are tissue
    for (int k = from.z; k < to.z; k++)
      for (int j = from.y; j < to.y; j++)
        for (int i = from.x; i < to.x; i++) {
          const Vec3 in_block = Vec3(Int3{i, j, k} - from) + Vec3{0.5f, 0.5f, 0.5f};
          if (is_tissue(
                  {in_block.x / float(block.x), in_block.y / float(block.y), in_block.z / float(block.z)},
                  slots))
            mass += ct.at(i, j, k) - kAirHu;
        }
    return mass;
  }
  bool is_tissue(Vec3 in_cell, const std::array<int, 8>& slots) const {
    const int tet = kuhn_tet_at(in_cell);
    const std::array<Int3, 4> nodes = kuhn_corners({0, 0, 0}, tet);
    const std::array<float, 4> weight = path_weights(tet, in_cell);
    bool any = false;
    float removed_weight = 0;
    for (std::size_t n = 0; n < 4; n++) {
      const int slot = slots[std::size_t(nodes[n].x + 2 * nodes[n].y + 4 * nodes[n].z)];
      any |= is_solid(slot);
      if (cuts.removed[std::size_t(slot)]) removed_weight += weight[n];
    }
    return any && !(removed_weight > 0.5f);
  }
};

}  // namespace

RestFrame rest_frame(const Model& model, const Grid& ct) {
  const Vec3d voxel = ct.spacing, step = model.anatomy.grid.spacing;
  return {.first_node = index_at(ct, model.anatomy.grid.origin),
          .cell_size = {step.x / voxel.x, step.y / voxel.y, step.z / voxel.z}};
}

double rest_mass(const Exec& exec, const Model& model, const Cuts& cuts, const CtVolume& ct) {
  const Int3 block = block_of(rest_frame(model, ct.grid).cell_size);
  std::vector<std::int64_t> layer_mass(std::size_t(model.anatomy.lattice.size.z - 1));
  parallel_for(exec, layer_mass.size(), LayerMass{model, cuts, ct, block, layer_mass});
  double mass = 0;
  for (const std::int64_t m : layer_mass) mass += double(m);
  return mass * sample_volume(ct.grid);
}

}  // namespace turgor::lattice

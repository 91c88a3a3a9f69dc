#include "turgor/models/lattice/build/change_tissue.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/models/lattice/build/partial_cells.hpp"
#include "turgor/models/lattice/build/scale_stiffness.hpp"
#include "turgor/models/lattice/build/springs.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {

namespace {

/// True if two layers are of one kind: both by depth, or regions of the same label or CT values.
bool is_same_region(const TissueLayer& a, const TissueLayer& b) { return a.label == b.label && a.hu == b.hu; }

/// Nodes of a built body, with the moduli of its parameters.
BodyNodes nodes_of(const Exec& exec, const Model& model) {
  const Anatomy& anatomy = model.anatomy;
  BodyNodes nodes;
  nodes.grid = anatomy.grid;
  nodes.regions = anatomy.regions;
  const Int3 size = nodes.grid.size;
  const std::size_t count = sample_count(nodes.grid);
  nodes.tissue.resize(count), nodes.young.resize(count), nodes.fixed.resize(count);
  parallel_for(exec, std::size_t(size.z), [&](std::size_t k) {
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, int(k));
        const auto slot = std::size_t(node_slot(anatomy.lattice, {i, j, int(k)}));
        const int label = anatomy.label.empty() ? 0 : anatomy.label[slot];
        nodes.tissue[n] = anatomy.tissue[slot];
        nodes.young[n] = modulus_of_node(nodes.tissue[n], label, model.params);
        nodes.fixed[n] = is_body(nodes.tissue[n]) && anatomy.inverse_mass[slot] == 0;
      }
  });
  return nodes;
}

/// Filled fraction from the modulus of a cell over that of its tissue. It is a count of voxels over all, or
/// the least fraction, so it is exact; in cells at the end of a scan it is rounded.
float exact_fraction(double ratio, Int3 block) {
  constexpr double kRounding = 2e-6;
  const double voxels = double(block.x) * block.y * block.z;
  for (const double fraction : {1.0, kLeastFraction, std::round(ratio * voxels) / voxels})
    if (std::abs(fraction - ratio) < kRounding * ratio) return float(fraction);
  return float(ratio);
}

/// Filled fractions and centers of the cells of a built body; empty without partial cells. Leaves the cells
/// of the model with the moduli of their tissue.
CellFill take_fill(const Exec& exec, Model& model) {
  const Anatomy& anatomy = model.anatomy;
  CellFill fill;
  if (anatomy.cell_center.empty()) return fill;
  const auto for_each_cell = [&](const auto& visit) {
    const Int3 size = anatomy.grid.size;
    parallel_for(exec, std::size_t(size.z), [&](std::size_t k) {
      for (int j = 0; j < size.y; j++)
        for (int i = 0; i < size.x; i++)
          visit(sample_index(anatomy.grid, i, j, int(k)),
                std::size_t(node_slot(anatomy.lattice, {i, j, int(k)})));
    });
  };
  fill.fraction.assign(sample_count(anatomy.grid), 1), fill.center.resize(fill.fraction.size());
  for_each_cell([&](std::size_t n, std::size_t slot) { fill.center[n].bits = anatomy.cell_center[slot]; });
  // moduli of full cells
  const aligned_vector<Real> filled = anatomy.cell_young;
  build_cells(exec, fill, model);
  for_each_cell([&](std::size_t n, std::size_t slot) {
    const double full = double(anatomy.cell_young[slot]);
    fill.fraction[n] = full > 0 ? exact_fraction(double(filled[slot]) / full, model.params.block) : 0;
  });
  return fill;
}

/// Pairs of the body and of each layer.
std::vector<int> pair_counts(const TissueParams& tissue) {
  std::vector<int> counts{pair_count(tissue.prony), has_set(tissue.set) ? 1 : 0};
  for (const TissueLayer& layer : tissue.layers)
    counts.push_back(pair_count(layer.prony.value_or(tissue.prony)));
  return counts;
}

}  // namespace

TissueParams reachable_tissue(const TissueParams& wanted, const Model& model) {
  const TissueParams& own = model.params.tissue;
  TissueParams tissue = wanted;
  tissue.air_max = own.air_max, tissue.fat_max = own.fat_max, tissue.bone_min = own.bone_min;
  tissue.partial_cells = own.partial_cells;
  if (model.anatomy.label.empty()) tissue.young_of_label = own.young_of_label;
  for (std::size_t n = 0; n < std::min(tissue.layers.size(), own.layers.size()); n++)
    if (norm(tissue.layers[n].fiber.direction) == 0)  // the axis of a label, found at loading
      tissue.layers[n].fiber.direction = own.layers[n].fiber.direction;
  // laws by cell need whole cells
  if (own.partial_cells && has_cell_laws(tissue)) return own;
  const bool same = tissue.law == own.law && tissue.energy == own.energy &&
                    std::equal(tissue.layers.begin(), tissue.layers.end(), own.layers.begin(),
                               own.layers.end(), is_same_region);
  return same ? tissue : own;
}

void change_tissue(const Exec& exec, const TissueParams& tissue, double scale, Model& model, State& state) {
  TURGOR_ASSERT(model.params.solver.method == Method::kVbd, "projections have no moduli");
  TURGOR_ASSERT(tissue.partial_cells == model.params.tissue.partial_cells, "cells stay partial or whole");
  const bool keeps_history = pair_counts(tissue) == pair_counts(model.params.tissue);
  const aligned_vector<Real> before = model.anatomy.cell_young;
  const CellFill fill = take_fill(exec, model);
  model.params.tissue = tissue;

  // springs and cells as in a new body
  const BodyNodes nodes = nodes_of(exec, model);
  const Int3 size = nodes.grid.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        if (const std::size_t n = sample_index(nodes.grid, i, j, k); is_body(nodes.tissue[n]))
          model.springs.root_stiffness[std::size_t(node_slot(model.anatomy.lattice, {i, j, k}))] =
              Real(std::sqrt(nodes.young[n]));
  const bool solid = tissue.law == TissueLaw::kSolid;
  const double volume = solid ? 0 : tissue.volume;
  model.springs.scale = calibrate_springs(model.anatomy.lattice.spacing, volume);
  model.springs.volume_scale = Real(volume);
  if (solid) build_cells(exec, fill, model);
  set_cell_laws(exec, nodes, model);
  if (scale != 1) scale_moduli(scale, model);

  // cut cells, history, and derived values
  for (CutCellElement& element : state.cut_elements.cells) {
    const auto slot = std::size_t(element.slot);
    if (before[slot] > 0) element.young *= model.anatomy.cell_young[slot] / before[slot];
  }
  if (!keeps_history) state.viscosity = {};
  state.workspace.coarse.reset();  // its operator has the former moduli
  state.sleep = {};                // wakes all rows
}

}  // namespace turgor::lattice

// Laws of cells by slot, and layers of tissue below the skin. A layer has a thickness; its depth is measured
// from the surface through the outermost nodes of the body. A cell that several layers share has their mean
// as springs in series, so that a pressed slab yields by the thicknesses whatever the spacing. Regions, which
// labels or CT values choose, replace layers by depth; cells at their borders have the same mean.
#pragma once

#include <span>
#include <vector>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

/// True if cells need laws of their own (law_cells.hpp): another energy, layers, viscosity or a permanent
/// set.
bool has_cell_laws(const TissueParams& tissue);

/// Depth of every body node [m]: its distance from the nearest body node beside outside. 100 m without
/// outside.
std::vector<float> node_depths(const Exec& exec, const BodyNodes& nodes);

/// Fills Anatomy::cell_laws, and the moduli of cells and nodes in layers. Bone that moves, gas and nodes with
/// a modulus of their label keep theirs. Does nothing without has_cell_laws.
void set_cell_laws(const Exec& exec, const BodyNodes& nodes, Model& model);

/// Mean of layers that share a cell: moduli as springs in series, and the energy of the layer that bears most
/// of the shear strain. `stiffening` averages the layers of this energy, and neo-Hookean ones, which are
/// exponential with b = 0 and Ogden with α = 2. Fibers lie side by side: their stiffnesses are averaged, and
/// the direction is that of the stiffest share.
struct LayerMean {
  double young, poisson, stiffening;
  SolidEnergy energy;
  FiberParams fiber;
  const TissueLayer* softest = nullptr;  // layer that bears most of the shear strain
};
struct SharedLayer {
  const TissueLayer* layer;
  double thickness;  // in any unit
};
/// `of_body`: energy of layers that have none of their own.
LayerMean mean_in_series(std::span<const SharedLayer> shared, SolidEnergy of_body);

/// Mean of the layers by depth over the depths [begin, end], by their thicknesses.
LayerMean mean_of_layers(const std::vector<TissueLayer>& layers, double begin, double end,
                         SolidEnergy of_body = SolidEnergy::kNeoHookean);

}  // namespace turgor::lattice

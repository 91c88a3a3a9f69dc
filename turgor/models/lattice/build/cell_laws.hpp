// Laws of cells by slot, and layers of tissue below the skin. A layer has a thickness; its depth is measured
// from the surface through the outermost nodes of the body. A cell that several layers share has their mean
// as springs in series, so that a pressed slab yields by the thicknesses whatever the spacing.
#pragma once

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

/// Mean of layers over the depths [begin, end]: shares of the thickness, and moduli as springs in series.
/// Fibers lie side by side: their stiffnesses are averaged, and the direction is that of the stiffest share.
struct LayerMean {
  double young, poisson, stiffening;
  FiberParams fiber;
};
LayerMean mean_of_layers(const std::vector<TissueLayer>& layers, double begin, double end);

}  // namespace turgor::lattice

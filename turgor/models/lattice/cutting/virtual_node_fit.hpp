// Virtual-node fit: displacements of virtual nodes without unknowns, extrapolated from the nodes on their
// side of the blade.
#pragma once

#include "turgor/models/lattice/cutting/crack_tips.hpp"
#include "turgor/models/lattice/cutting/fragment_stages.hpp"

namespace turgor::lattice {

/// Computes the fit terms of all virtual nodes: weights of a linear fit to connected nodes nearby [moving
/// least squares, Lancaster and Salkauskas 1981].
///
/// The fit is not extrapolated across the blade. The half cell between a lip's last nodes and the blade moves
/// with these nodes instead. Linear extrapolation would overshoot, because the nodes of a lip move much more
/// than those behind them.
void fit_virtual_nodes(const Model& model, const Cuts& cuts, const CutEdgesByCell& edges,
                       const EarlierFragments& earlier, Fragments& fragments);

}  // namespace turgor::lattice

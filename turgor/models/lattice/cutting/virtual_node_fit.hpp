// Where copies of nodes go: with the tissue on their side of the blade.
#pragma once

#include "turgor/models/lattice/cutting/crack_tips.hpp"

namespace turgor::lattice {

/// Fills in the sources of all copies: the weights of a linear fit to the nodes near a copy, on its side
/// [moving least squares, Lancaster and Salkauskas 1981]. Across a blade it does not go on: the last layer of
/// nodes beside the blade carries what is left of the step up to it. (On a line it would go too far: a lip's
/// nodes have moved by much more than those behind them.)
void find_sources(const Model& model, const State& state, const EdgesOfCells& edges, Fragments& pieces);

}  // namespace turgor::lattice

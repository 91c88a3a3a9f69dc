// Topology of cut cells: the cut-cell and cut-skin elements of a body (State::cut_elements). Forces of these
// elements are in mechanics/cut_elements.hpp. [Molino et al. 2004; Wang et al. 2014]
#pragma once

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Rebuilds Cuts::fragments and State::cut_elements after a cut. Virtual nodes from before the cut keep their
/// displacements. New ones get the displacement of the tissue on their side. Only the nodes that determine it
/// are downloaded.
void build_cut_elements(const Model& model, State& state, const DownloadNodes& download = {});

/// Shares Model::prestress_force among the nodes of the present cut elements again, after it has changed.
void renew_prestress(const Model& model, const Cuts& cuts, CutElements& elements);

/// Marks the rows around a slot as cut (Cuts::row_cut).
void mark_rows(const Model& model, Cuts& cuts, int slot);

}  // namespace turgor::lattice

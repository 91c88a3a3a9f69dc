// Cells that a blade enters and does not part: there the two sides of the cut are those of a plane through
// it, so that a wound tapers to where the blade ended and not to the last cell that it went all the way
// through.
#pragma once

#include <optional>

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Which cut edges lie in which cell.
struct EdgesOfCells {
  std::vector<std::pair<int, int>> pairs;  // cell, edge; in order
};

/// Is an edge of the lattice between two corners of this cell cut?
bool has_cut_edge(const State& state, const Lattice& lattice, int slot);

/// Across the plane that places lie nearest to, a unit vector.
Vec3d flattest_way(const std::vector<Vec3d>& places);
/// Of one incision, or of all (-1).
std::optional<CrackTipPlane> fit_tip(const State& state, const Fragments& pieces, const EdgesOfCells& edges,
                                     const CutCell& cell, int incision = -1);

}  // namespace turgor::lattice

// Crack tips: cells that a blade entered but did not separate. Such a cell is split by a plane, which is
// fitted to the cut edges in and around it. The wound then tapers to the end of the blade. Without this split
// it would end at the last separated cell.
#pragma once

#include <optional>

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Incidence of cut edges and cells.
struct CutEdgesByCell {
  std::vector<std::pair<int, int>> pairs;  // (index of cell, index of cut edge), sorted
};

/// True if a lattice edge between two corners of this cell is cut.
bool has_cut_edge(const Cuts& cuts, const Lattice& lattice, int slot);

/// Unit normal of the best-fitting plane through positions: the direction of least variance.
Vec3d flattest_direction(const std::vector<Vec3d>& positions);
/// Weighted least-squares plane through the cut points in and around a cell. It uses one incision, or all if
/// `incision` is -1. Empty without cut points.
std::optional<CrackTipPlane> fit_crack_tip_plane(const Cuts& cuts, const Fragments& fragments,
                                                 const CutEdgesByCell& edges, const CutCell& cell,
                                                 int incision = -1);
/// True if a blade only touches the boundary of a cell with its end, as where it ends at a node: it crosses
/// no sample line of the cell (cut_fraction.hpp), and none of its cuts around the cell lies farther along it.
bool is_behind_end(const Cuts& cuts, const Fragments& fragments, const CutEdgesByCell& edges,
                   const CutCell& cell, const CrackTipPlane& plane, std::uint8_t incision);

}  // namespace turgor::lattice

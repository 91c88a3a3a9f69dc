// Fragments of cut cells that can be elements, and the virtual nodes that their elements solve for.
#pragma once

#include <array>

#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// True if the law and the method of a body have elements in cut cells.
bool has_cut_elements(const Model& model);

/// True if cut elements replace a cell: it was whole, is now cut or has a virtual node, and no node is
/// removed.
bool is_cut_cell(const Model& model, const Cuts& cuts, const Fragments& fragments, const CutCell& cell);

/// True if a fragment of a cell that is an element can be one: each corner is a node of tissue, or of the rim
/// of partial cells, or a virtual node of one with a fit. Other fragments have no fit, or are excised.
bool can_be_element(const Model& model, const Cuts& cuts, const Fragments& fragments,
                    const Fragment& fragment);

/// Corners of the bridge element at a crack tip. Each corner is taken from the fragment on its side of the
/// plane. If one of the fragments cannot be an element, the nodes of the cell are used.
std::array<int, 8> bridge_corners(const Model& model, const Cuts& cuts, const Fragments& fragments,
                                  const CutCell& cell, const CrackTip& tip);

/// Marks the virtual nodes that are unknowns: corners of cut-cell elements, except those that only slivers
/// hold.
///
/// A sliver is an element of less than a hundredth of a cell. The skin of a lip can have a virtual node in
/// common with a sliver alone. The tension of the skin would carry such a node away. It moves by its fit
/// instead, and its elements are left out. A sliver that alone holds a node of the lattice remains an
/// element.
void mark_virtual_nodes_with_unknowns(const Model& model, const Cuts& cuts, Fragments& fragments);

/// True if all virtual nodes among these corners are unknowns. Only such elements are added.
bool has_all_unknowns(const Fragments& fragments, const std::array<int, 8>& corners);

}  // namespace turgor::lattice

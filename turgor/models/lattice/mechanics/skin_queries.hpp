// Queries on the skin triangles of a body: their cells, their edges, and the triangles opened by a cut.
// Detection of skin is in build/skin.hpp.
#pragma once

#include <span>

#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// Lowest node of a cell that contains a skin triangle, given by its three slots.
Int3 cell_of(const Lattice& lattice, Int3 triangle);

/// Skin triangles in layers of cells.
std::span<const SkinTriangle> skin_of_cells(const Model& model, Layers layers);

/// Patches in layers of cells.
std::span<const SkinPatch> patches_of_cells(const Model& model, Layers layers);
/// Index of the patch of a cell, by the slot of its lowest node; -1 if it has none.
int patch_of_cell(const Skin& skin, int slot);

/// Edge between two neighbor slots: slot of the lower end, and family.
struct Edge {
  int slot = 0;
  int family = -1;  // -1: not neighbors
};
Edge edge_between(const Lattice& lattice, int a, int b);

/// Marks triangles with a cut edge, or patches in cells that are not whole (Cuts::skin_cut).
void cut_skin(const Model& model, Cuts& cuts);

}  // namespace turgor::lattice

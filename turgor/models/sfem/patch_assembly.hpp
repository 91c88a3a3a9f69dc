// The matrices of a patch before elimination: K_L of the local functions, K_LG that couples them to the
// coarse ones, and what the patch changes in the coarse stiffness itself.
#pragma once

#include <vector>

#include "turgor/models/sfem/refinement.hpp"

namespace turgor::sfem {

/// Numbering of the unknowns: coarse vertices in ascending order; local functions with those of the touched
/// surface last, so that the end of a Cholesky factor belongs to them.
struct PatchUnknowns {
  std::vector<int> coarse;  // vertices, all free
  std::vector<int> local;   // of each fine node; -1 = none of its own
  int local_count = 0;
  int first_touched = 0;  // local functions from this index on are on the touched surface
};

/// Column-major. `change` is empty when the fine elements restricted to coarse functions have exactly the
/// stiffness of the coarse ones: standard elements of one material that are subdivided into congruent parts.
template <class T>
struct PatchMatrices {
  std::vector<T> local;     // K_L, 3·local square, lower triangle only
  std::vector<T> coupling;  // K_LG, 3·local × 3·coarse
  std::vector<T> change;    // 3·coarse square
};

/// Materials of the fine elements: an inclusion is resolved at the patch's resolution.
std::vector<int> fine_materials(const Model& model, const FineMesh& fine);

/// True when the patch changes the coarse stiffness.
bool changes_stiffness(const Model& model, std::span<const int> elements, const FineMesh& fine);

/// Elements whose coarse stiffness the patch changes: its own, and with node-averaged tetrahedra also those
/// around it. Ascending.
std::vector<int> changed_elements(const Model& model, std::span<const int> elements);

template <class T>
PatchMatrices<T> assemble_patch(const Model& model, std::span<const int> elements, const FineMesh& fine,
                                const PatchUnknowns& unknowns, bool with_change);

/// Stiffness between the functions of one coarse element: local ones, then coarse ones.
struct PatchPiece {
  std::vector<int> functions;  // ascending: index of a local function, or local_count + index of a coarse one
  std::vector<double> values;  // column-major, lower half; zero between coarse functions
};
/// The same matrices, not yet summed over the coarse elements.
struct PatchPieces {
  std::vector<PatchPiece> of_element;
  std::vector<double> change;  // as PatchMatrices::change
};

/// For elements that are not node-averaged, which would couple functions of different elements.
PatchPieces assemble_pieces(const Model& model, std::span<const int> elements, const FineMesh& fine,
                            const PatchUnknowns& unknowns, bool with_change);

}  // namespace turgor::sfem

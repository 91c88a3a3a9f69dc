// Excision of an ellipse or disc of skin. A blade follows the outline and a floor at its depth, so that the
// piece is a connected component of its own. The piece then leaves the body: its fragments are marked, its
// nodes are excised, and the walls of the wound remain.
#pragma once

#include "turgor/models/lattice/cutting/blade_sheet.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Outline on the skin, patient frame [m]: from one end along the right side of its length to the other end,
/// and back. Points n and count − 1 − n lie on opposite sides. The last point is the first. Errors: no skin
/// near the center, or a direction that is normal to the skin.
Result<std::vector<Vec3d>> excision_outline(const Model& model, const State& state, const Excision& excision);

/// True if a point of one outline lies inside the other. Outlines are those of excision_outline.
bool outlines_overlap(std::span<const Vec3d> a, std::span<const Vec3d> b);

/// Sheet of an excision: walls along the outline of a path, from `margin` above the skin to the depth of each
/// point, and a floor, which is cut last. `middle`: center of the floor [m]. The sheet is closed below the
/// skin and shifted by about `epsilon`, so that no node of a regular lattice lies in it.
BladeSheet excision_sheet(const BladePath& path, Vec3d middle, double margin, double epsilon);

/// Tissue that a blade cut free: whole cells and fragments. Fragment −1 is a whole cell.
struct FreePiece {
  std::vector<std::pair<int, int>> tissue;  // slot of the cell's lowest node, fragment; ascending
  std::vector<int> nodes;                   // tissue nodes, ascending slots
  std::vector<std::uint64_t> sub_nodes;     // for Cuts::excised, ascending
};
/// Finds the piece inside the walls of an incision that is complete. Errors: no piece, a piece that is still
/// connected to the body, or fixed tissue in it.
Result<FreePiece> find_piece(const Model& model, const Cuts& cuts, int incision);
/// All tissue near cuts and all nodes that do not belong to a piece.
FreePiece rest_of_body(const Model& model, const Cuts& cuts, const FreePiece& piece);

/// Volume [m³] and mass [kg] of a piece, from the fractions of its cells that are tissue.
struct PieceMass {
  double volume = 0, mass = 0;
};
PieceMass mass_of(const Model& model, const Cuts& cuts, const FreePiece& piece);

/// Takes a piece out of the body, and wakes all rows.
void excise(const Model& model, State& state, const FreePiece& piece);
/// Marks a piece as excised without the elements of the body, for a state read from a recording.
void mark_excised(const FreePiece& piece, Cuts& cuts);

}  // namespace turgor::lattice

// What the cells of a cut body fall apart into. Along a blade's surface the edges of the fine lattice are
// cut; the tissue of a cell that still holds together inside it is a piece. A node is there once for every
// part of the tissue around it: as itself for the part it lies in, as a copy for each other one [virtual
// nodes: Molino, Bao and Fedkiw 2004; Sifakis, Der and Fedkiw 2007; Wang, Jiang, Schroeder and Teran 2014].
// So the displacement of any point is trilinear in the eight corners of its piece: drawing, measuring and
// resampling ask for nothing else.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/models/lattice/cutting/fine_lattice.hpp"
#include "turgor/models/lattice/key_index.hpp"

namespace turgor::lattice {

/// The tissue of one cell that holds together. A corner is a slot of the lattice, or slot_count + number of a
/// copy.
struct Fragment {
  int cell = 0;             // index into Pieces::cells
  std::uint64_t place = 0;  // fine node of its tissue with the lowest index
  bool thin = false;        // it has no area in any face of its cell
  std::array<int, 8> corner{};
};

/// A cell near a cut.
struct CutCell {
  int slot = 0;  // of its lowest node
  int first_fragment = 0, fragment_count = 0;
  std::size_t places = 0;            // its first in Pieces::label and Pieces::cut
  bool is_cut = false;               // an edge in it is cut; else it is beside such a cell
  int first_tip = 0, tip_count = 0;  // Pieces::tips
  int first_ghost = 0, ghost_count = 0;
};

/// A plane through what is cut in and around a cell, by least squares; negative on the blades' left side.
struct CrackTipPlane {
  Vec3d center, normal;  // [steps of the lattice]

  double at(Vec3d place) const { return dot(place - center, normal); }
};
/// What a blade entered and did not part: two pieces of a cell, to both sides of a plane.
struct CrackTip {
  CrackTipPlane plane;
  int left = 0, right = 0;    // of the cell's pieces
  std::uint8_t incision = 0;  // of the scene
};

/// Where the CT's skin lies beyond the lattice's, a cell may have places on a side of a blade where it has no
/// tissue. They go with the tissue on their side, a piece of a cell beside it, on whose trilinear
/// displacement goes on into the cell: a guest.
struct GhostFragment {
  int slot = 0;             // of the cell's lowest node
  int cell = 0, piece = 0;  // whose it is: index into Pieces::cells, and which of its pieces
};

/// A copy of a node. One that bears tissue has a displacement of its own (State::copies). Others go where the
/// tissue on their side leads: Σ weight · displacement of `sources`.
struct VirtualNode {
  int slot = 0;                     // of the node
  std::uint64_t place = 0;          // fine node of its tissue with the lowest index
  int first = 0, source_count = 0;  // sources
  bool bears = false;
};
struct FitTerm {
  int corner = 0;  // of a piece
  Real weight = 0;
};

struct Fragments {
  FineLattice fine;
  std::vector<CutCell> cells;         // slots ascend
  KeyIndex cell_index;                // of a slot: index into cells
  std::vector<Fragment> pieces;       // cell by cell
  std::vector<GhostFragment> ghosts;  // cell by cell
  // By place of a cell: which of its pieces; -2 - n: its guest n; -1: nothing on its own side of the blades.
  std::vector<std::int16_t> label;
  std::vector<std::uint8_t> cut;  // by place: bit f = the edge of family f that starts there is cut
  std::vector<VirtualNode> virtual_nodes;
  std::vector<FitTerm> sources;
  std::vector<CrackTip> tips;  // cell by cell
  KeyIndex edge_index;         // of a fine edge's key: index into State::cut_edges
  std::size_t version = 0;     // cut_version of the state that they were made of
};

Fragments make_fragments(const Model& model, const State& state);

/// The cell near a cut that this slot is the lowest node of; null for others.
inline const CutCell* find_cell(const Fragments& pieces, int slot) {
  const int index = pieces.cell_index.find(std::uint64_t(slot));
  return index < 0 ? nullptr : &pieces.cells[std::size_t(index)];
}
/// The cut edge between two neighbouring fine nodes, null when it is whole; and where it is cut, from `a` on.
struct Crossing {
  const CutEdge* edge = nullptr;
  Real fraction = 0;
  bool rightward = false;  // from a to b
};
Crossing crossing(const Fragments& pieces, const State& state, Int3 a, Int3 b);

/// The piece of a place of a cell, from Pieces::label, guests after its own; the first one where there is
/// none on its own side; -1 in air without any.
TURGOR_HD inline int piece_of(const std::int16_t* label, const CutCell& cell, int place) {
  const int piece = label[cell.places + std::size_t(place)];
  if (piece < -1) return cell.fragment_count - 2 - piece;
  return piece < 0 && cell.fragment_count > 0 ? 0 : piece;
}
/// Which piece of its cell, or guest after its own, holds a point, from its coordinates in the cell, 0 to 1;
/// -1 where there is none.
int fragment_at(const Fragments& pieces, const State& state, const CutCell& cell, Vec3 at);

/// How much tissue a fine node is, by the nodes of the lattice: positive inside, linear between nodes through
/// the threshold of air [HU].
Real node_level(const Model& model, const State& state, int slot);

/// Has a corner a displacement that is solved for: a node of tissue, or a copy that bears some?
inline bool is_borne(const Model& model, const State& state, const Fragments& pieces, int corner) {
  const int slots = slot_count(pieces.fine.cells);
  return corner < slots ? is_solid(model, state, corner)
                        : pieces.virtual_nodes[std::size_t(corner - slots)].bears;
}
/// Displacement of a corner of a piece: of a node, of a copy, or of air beside the body, which follows it
/// [m].
Vec3 corner_displacement(const Model& model, const State& state, const Fragments& pieces, int corner);

/// The nodes that it is found from, added to a list.
void add_nodes_behind(const Model& model, const State& state, const Fragments& pieces, int corner,
                      std::vector<int>& nodes);

/// Displacement of a corner of the cell that a guest is in, 0 to 7, as that of the guest's own cell goes on
/// [m].
Vec3 ghost_displacement(const Model& model, const State& state, const Fragments& pieces, int ghost,
                        int corner);

/// A cell that is not drawn as a whole: it is in pieces, which do not all go with its own nodes, or nodes of
/// it left the body.
struct SpecialCell {
  int slot = 0;
  int cut = -1;  // index into Pieces::cells; -1: one piece
};
/// Slots ascend.
std::vector<SpecialCell> special_cells(const Model& model, const State& state, const Fragments& pieces);

/// The corners of a piece of a cell that is its own, or of a whole cell when `piece` is -1.
std::array<int, 8> corners_of(const Model& model, const Fragments& pieces, int slot, int piece);

}  // namespace turgor::lattice

// Fragments of cut cells by the virtual node algorithm [Molino, Bao and Fedkiw 2004; Sifakis, Der and Fedkiw
// 2007; Wang, Jiang, Schroeder and Teran 2014].
//
// Blades cut edges of the fine lattice. A fragment is a connected component of a cell's tissue along uncut
// fine edges. The fragments around a node form groups that are connected across cell faces. The group that
// contains the node keeps it; every other group gets a virtual node. The displacement of any point is then
// trilinear in the eight corners of its fragment.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "turgor/core/key_index.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"

namespace turgor::lattice {

/// Connected tissue of one cell. A corner is a slot of the lattice, or slot_count + index of a virtual node.
struct Fragment {
  int cell = 0;                   // index into Fragments::cells
  std::uint64_t lowest_node = 0;  // lowest fine-node index of its tissue
  bool thin = false;              // no area in any face of its cell
  bool excised = false;           // left the body with a piece (excision.hpp)
  std::array<int, 8> corner{};
};

/// Cell with a cut edge, or a neighbor of such a cell.
struct CutCell {
  int slot = 0;  // of the cell's lowest node
  int first_fragment = 0, fragment_count = 0;
  std::size_t first_sub_index = 0;   // first index in Fragments::label and Fragments::cut_bits
  bool is_cut = false;               // true: an edge in it is cut; false: only a neighbor's is
  int first_tip = 0, tip_count = 0;  // Fragments::tips
  int first_ghost = 0, ghost_count = 0;
};

/// Least-squares plane through the cut points in and around a cell. The signed distance is negative on the
/// blade's left side.
struct CrackTipPlane {
  Vec3d center, normal;  // [cells]

  double signed_distance(Vec3d position) const { return dot(position - center, normal); }
};
/// Crack tip: a blade entered a cell without separating it, and a plane splits it into two fragments.
struct CrackTip {
  CrackTipPlane plane;
  int left = 0, right = 0;    // indices among the cell's fragments
  std::uint8_t incision = 0;  // index of the scene's incision
};

/// Ghost fragment. Where the skin of the CT lies outside the lattice's tissue, one side of a blade in a cell
/// may contain fine nodes but no tissue. These fine nodes belong to a fragment of a neighboring cell on their
/// side. Its trilinear displacement is extrapolated into this cell.
struct GhostFragment {
  int slot = 0;                // of the cell's lowest node
  int cell = 0, fragment = 0;  // owner: index into Fragments::cells, and fragment in that cell
};

/// Virtual node. With unknowns, it has a displacement of its own (Motion::virtual_u). Otherwise its
/// displacement is a linear combination of corner displacements, Σ weight · u(corner) over its fit terms.
struct VirtualNode {
  int slot = 0;                        // of the original node
  std::uint64_t lowest_node = 0;       // lowest fine-node index of its tissue
  int first_term = 0, term_count = 0;  // in Fragments::fit_terms
  bool has_unknowns = false;
};
struct FitTerm {
  int corner = 0;  // as in Fragment::corner
  Real weight = 0;
};

/// Connected groups of the fragments around nodes, before small components are merged (virtual_nodes.hpp).
struct NodeGroups {
  std::vector<int> slot;           // of the nodes, ascending
  std::vector<int> begin{0};       // by node, and the end: indices into `root`
  std::vector<std::int16_t> root;  // by fragment around the node: a fragment that represents its group
};

/// Intermediate results that fragments of later cuts reuse (fragment_stages.hpp).
struct FragmentStages {
  std::size_t edges = 0;                            // cut edges
  std::uint64_t edges_hash = 0;                     // of these edges
  int removed_nodes = 0;                            // Cuts::removed_nodes
  std::size_t excised = 0;                          // size of Cuts::excised
  std::vector<std::uint64_t> corner_cuts;           // by cell: cut bits at its corners
  std::vector<std::int16_t> tissue;                 // Fragments::label before air is labeled
  std::vector<int> whole;                           // by fragment: sub-cells without cut edges in it
  std::vector<std::optional<CrackTipPlane>> plane;  // by cell: all blades in and around it
  std::vector<std::uint8_t> is_plane_known;         // by cell
  NodeGroups groups;
};

struct Fragments {
  FineLattice fine;
  std::vector<CutCell> cells;         // ascending slots
  KeyIndex cell_index;                // from slot to index into cells
  std::vector<Fragment> all;          // grouped by cell
  std::vector<GhostFragment> ghosts;  // grouped by cell
  // fragment of each sub-lattice node, cell by cell; -2 - n: ghost n; -1: no tissue on its side of the blades
  std::vector<std::int16_t> label;
  std::vector<std::uint8_t>
      cut_bits;  // by sub-lattice node: bit f = the edge of family f from this node is cut
  std::vector<VirtualNode> virtual_nodes;
  std::vector<FitTerm> fit_terms;
  std::vector<CrackTip> tips;  // grouped by cell
  KeyIndex edge_index;         // from fine-edge key to index into Cuts::edges
  std::size_t version = 0;     // cut_version of the cuts that these fragments follow from
  FragmentStages stages;
};

/// Fragments of the cuts. `before` saves time and does not change them: fragments of the same body when some
/// of the last edges were not yet cut, or null.
Fragments make_fragments(const Model& model, const Cuts& cuts, const Fragments* before = nullptr);
/// Fragments of these cuts: those stored with them, or new ones if the stored ones are of another version.
std::shared_ptr<const Fragments> fragments_of(const Model& model, const Cuts& cuts);
/// Computes the fragments of these cuts and stores them.
void store_fragments(const Model& model, Cuts& cuts);

/// Cut cell with this lowest slot; null if the cell is not near a cut.
inline const CutCell* find_cell(const Fragments& fragments, int slot) {
  const int index = fragments.cell_index.find(std::uint64_t(slot));
  return index < 0 ? nullptr : &fragments.cells[std::size_t(index)];
}
/// Cut on the edge between two neighboring fine nodes, as a fraction of the edge from `a`. `edge` is null if
/// the edge is not cut.
struct Crossing {
  const CutEdge* edge = nullptr;
  Real fraction = 0;
  bool rightward = false;  // true: the edge from a to b leads to the blade's right side
};
Crossing crossing(const Fragments& fragments, const Cuts& cuts, Int3 a, Int3 b);

/// Index in its cell of the fragment of a sub-lattice node, read from Fragments::label. Ghosts are numbered
/// after the cell's own fragments. Nodes without a label get the first fragment, or -1 if the cell has none.
TURGOR_HD inline int fragment_of(const std::int16_t* label, const CutCell& cell, int sub_node) {
  const int fragment = label[cell.first_sub_index + std::size_t(sub_node)];
  if (fragment < -1) return cell.fragment_count - 2 - fragment;
  return fragment < 0 && cell.fragment_count > 0 ? 0 : fragment;
}
/// Index in its cell of the fragment that contains a point. Ghosts are numbered after the cell's own
/// fragments; -1 if the cell has neither. `at` is in cell coordinates, 0 to 1.
int fragment_at(const Fragments& fragments, const Cuts& cuts, const CutCell& cell, Vec3 at);

/// Level-set value of a node [HU]: HU minus the air threshold, positive in the body. The sign follows the
/// node's tissue class, and the magnitude is at least 4 HU. Gas in the body gets 500 HU, a removed node -500
/// HU.
Real node_level(const Model& model, const Cuts& cuts, int slot);

/// True if the displacement of a corner is solved for: a node of tissue or rim, or a virtual node with
/// unknowns.
inline bool has_unknowns(const Model& model, const Cuts& cuts, const Fragments& fragments, int corner) {
  const int slots = slot_count(fragments.fine.cells);
  return corner < slots ? has_displacement(model, cuts, corner)
                        : fragments.virtual_nodes[std::size_t(corner - slots)].has_unknowns;
}
/// Displacement of a fragment corner [m]: a node, a virtual node, or an air node, which is extrapolated from
/// tissue.
Vec3 corner_displacement(const Model& model, const State& state, const Fragments& fragments, int corner);

/// Appends the nodes that determine the displacement of a corner. `virtual_u` is Motion::virtual_u. Only its
/// size is used, because virtual nodes with unknowns depend on no node.
void add_support_nodes(const Model& model, const Cuts& cuts,
                       std::span<const VirtualNodeDisplacement> virtual_u, const Fragments& fragments,
                       int corner, std::vector<int>& nodes);

/// Displacement of corner 0 to 7 of the cell that contains a ghost [m]. It is extrapolated from the cell that
/// owns the ghost.
Vec3 ghost_displacement(const Model& model, const State& state, const Fragments& fragments, int ghost,
                        int corner);

/// Cell that is rasterized fragment by fragment. It has several fragments, ghosts, virtual nodes or removed
/// nodes.
struct SpecialCell {
  int slot = 0;
  int cut = -1;  // index into Fragments::cells; -1: a single fragment
};
/// Special cells with ascending slots.
std::vector<SpecialCell> special_cells(const Model& model, const Cuts& cuts, const Fragments& fragments);

/// Corners of one of a cell's own fragments. If `fragment` is -1, the nodes of the cell.
std::array<int, 8> corners_of(const Model& model, const Fragments& fragments, int slot, int fragment);

}  // namespace turgor::lattice

// State of a lattice body: motion, cuts, elements of cut cells, sleep and workspaces. Constant data is in
// model.hpp.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Vector field by slot, one array per component.
struct VecField {
  aligned_vector<Real> x, y, z;

  Vec3 operator[](std::size_t slot) const { return {x[slot], y[slot], z[slot]}; }
  void set(std::size_t slot, Vec3 value) { x[slot] = value.x, y[slot] = value.y, z[slot] = value.z; }
  void resize(std::size_t count) { x.resize(count), y.resize(count), z.resize(count); }
};

/// Edge of the fine lattice (fine_lattice.hpp) cut by a blade.
struct CutEdge {
  int slot = 0;       // of the cell's lowest node
  int sub_index = 0;  // lower end of the edge in that cell: x + 8 y + 64 z in fine steps
  std::uint8_t family = 0;
  std::uint8_t incision = 0;   // incision of the scene
  std::uint8_t rightward = 0;  // 1 = from the blade's left side to its right side
  Real fraction = 0;           // position of the cut from the lower end, in [0, 1]
  Real along = 0;              // arc length on the blade's path [m]
};

/// Sample lines of a cell, 8 × 8 along each axis (cut_fraction.hpp), that a blade crossed.
struct CutFractionSamples {
  int slot = 0;               // of the cell's lowest node
  std::uint8_t incision = 0;  // of the scene
  std::array<std::uint64_t, 3> lines{};
};

/// Displacement of a virtual node (fragments.hpp), along the axes of the lattice [m].
struct VirtualNodeDisplacement {
  Real x = 0, y = 0, z = 0;

  TURGOR_HD void move(Vec3 by) { x += by.x, y += by.y, z += by.z; }
};

/// Cut-cell element: one fragment of a cell. A corner is a slot, or slot_count + index of a virtual node.
struct CutCellElement {
  std::array<int, 8> corner{};
  Real young = 0;       // modulus of the cell times the fragment's volume fraction [Pa]
  int slot = 0;         // of the cell's lowest node
  int patch = -1;       // skin of the cell (Skin::patches); -1 = none
  Real skin_share = 0;  // fraction of the patch's area [1]
};
/// Cut-skin element: a skin triangle on one side of a blade. Corners as in CutCellElement.
struct CutSkinElement {
  int triangle = 0;
  Int3 corner;     // of its vertices
  Real share = 0;  // fraction of the triangle's area [1]
};
/// Node or virtual node that is a corner of cut elements.
struct ElementNode {
  int corner = 0, slot = 0;  // index as in CutCellElement; slot of the lattice node it belongs to
  int first = 0, count = 0;  // in CutElements::references
  Vec3 prestress_force;      // share of Model::prestress_force; for nodes, its change [N]
};
/// Reference from a node to corner `at` of cells[element], or of skin[-1 - element] when negative.
struct NodeElementReference {
  int element = 0, at = 0;
};
/// Elements of cut cells and cut skin (cut_elements.hpp).
struct CutElements {
  std::vector<CutCellElement> cells;
  std::vector<CutSkinElement> skin;
  std::vector<ElementNode> nodes, virtual_nodes;  // slots ascend in both
  std::vector<int> layer_begin;                   // of virtual nodes: size.z + 1 entries
  std::vector<NodeElementReference> references;
  std::vector<std::pair<int, std::uint64_t>>
      virtual_node_keys;  // slot and fine node of each virtual node; identifies it after the next cut
};

/// Sleep of rows (sleep.hpp), by row of the storage. Empty before the first step of a body that can sleep.
struct Sleep {
  std::vector<std::uint8_t> still_steps;  // age: steps without motion nearby; sleeps from kStillSteps on
  std::vector<std::uint8_t> awake;        // 1 = swept in this step
  std::vector<std::uint8_t> moved;        // 1 = one of its nodes moved in this step
  std::size_t cuts = 0;                   // cut edges that were already handled
  Vec3d gravity;                          // gravity of the current rest state [m/s²]
  bool moved_by_coarse = false;           // the coarse correction moves all rows in this step
  std::uint8_t coarse_still_steps = 0;    // age of the coarse space: steps in which all rows slept
};

/// Space of the coarse correction (coarse_correction.hpp).
struct CoarseSpace;
/// Connected tissue of cut cells (fragments.hpp).
struct Fragments;

/// Workspace for residual forces along the axes of the lattice: two layers of nodes per chunk of layers, and
/// all virtual nodes.
struct ResidualWorkspace {
  std::vector<VecField> layers;                        // by chunk [N]
  std::vector<VirtualNodeDisplacement> virtual_nodes;  // [N]
};

/// Bit of Cuts::cut: cut elements (State::cut_elements) replace the cell whose lowest node is at this slot.
constexpr std::uint8_t kCutCell = 1u << kFamilyCount;

/// Motion of the nodes and virtual nodes.
struct Motion {
  double time = 0;          // [s]
  VecField u, u_before, v;  // displacement now and before the step [m]; velocity [m/s]
  Real fastest = 0;         // largest |v| [m/s]
  std::vector<VirtualNodeDisplacement> virtual_u,
      virtual_u_before;  // of virtual nodes, numbered by make_fragments
};

/// Values of Cuts::removed. A removed node is air (static incision of the paper). An excised node left the
/// body with a piece: its virtual nodes on the other side of the blade remain.
constexpr std::uint8_t kRemoved = 1, kExcised = 2;

/// Cuts and removed nodes.
struct Cuts {
  aligned_vector<std::uint8_t> cut;  // by slot: bit f = the edge of family f that starts at the slot is cut;
                                     // kCutCell = cut elements replace the cell
  aligned_vector<std::uint8_t> removed;     // by slot: kRemoved or kExcised = no longer in the body
  std::vector<std::uint8_t> row_cut;        // by row: 1 = this row or a neighbor row has a cut edge
  std::vector<std::uint8_t> skin_cut;       // by skin triangle or patch: 1 = no tension
  std::vector<CutEdge> edges;               // in the order of cutting
  std::vector<CutFractionSamples> samples;  // by slot and incision
  int sample_count = 0;                     // crossed lines in all samples
  int removed_nodes = 0;                    // removed nodes in total
  std::vector<std::uint64_t> excised;       // sub-lattice nodes of excised fragments (excision.hpp), sorted
  std::bitset<256> active_blades;           // by incision: the blade is still moving
  std::shared_ptr<const Fragments> fragments;  // derived from the cuts when a blade moves; see fragments_of
};

/// Symmetric tensor field by slot, one array per entry.
struct SymmetricField {
  aligned_vector<Real> xx, yy, zz, xy, xz, yz;
};
/// Relaxation of solid cells (solver/viscosity.hpp).
struct Viscosity {
  std::vector<SymmetricField>
      history;                    // by Prony pair, by slot of the cell's lowest node; empty = at rest [J]
  Real instant = 1;               // factor of the moduli within a step [1]
  aligned_vector<Real> instants;  // the same by slot, where layers have pairs of their own; else empty
  bool in_step = false;           // the first field holds the sum over the pairs
};

/// Coarse space and memory that steps reuse.
struct Workspace {
  std::shared_ptr<const CoarseSpace> coarse;  // derived from the cuts and the time step
  ResidualWorkspace residual;                 // scratch memory
  std::size_t cuts_before = 0;                // cut_version before the last step
  int steps_since_cut = 0;
};

/// Variable data of a body.
struct State {
  Motion motion;
  Cuts cuts;
  CutElements cut_elements;  // derived from the cuts
  Sleep sleep;
  Workspace workspace;
  Viscosity viscosity;
};

/// Downloads positions and velocities of the given nodes (ascending) into the state. Null when the state is
/// on the host (device_state.hpp).
using DownloadNodes = std::function<void(std::span<const int>)>;

/// Current position of a node, along the axes of the lattice, from the first node of the body [m].
inline Vec3 position(const Model& model, const Motion& motion, Int3 node) {
  return rest_position(model.anatomy.lattice, node) +
         motion.u[std::size_t(node_slot(model.anatomy.lattice, node))];
}
/// True if a node of the body is removed and not excised. Rim nodes that a cut has loosened are removed too,
/// but were no tissue.
inline bool is_removed_tissue(const Model& model, const Cuts& cuts, int slot) {
  return is_body(model.anatomy.tissue[std::size_t(slot)]) && cuts.removed[std::size_t(slot)] == kRemoved;
}
/// True if a node was tissue before excisions.
inline bool was_solid(const Model& model, const Cuts& cuts, int slot) {
  return model.anatomy.tissue[std::size_t(slot)] != Tissue::kOutside &&
         cuts.removed[std::size_t(slot)] != kRemoved;
}
/// True if a node is tissue: neither outside nor removed or excised.
inline bool is_solid(const Model& model, const Cuts& cuts, int slot) {
  return model.anatomy.tissue[std::size_t(slot)] != Tissue::kOutside && cuts.removed[std::size_t(slot)] == 0;
}
/// True if the displacement of a node is an unknown or fixed: tissue or rim that is not removed.
inline bool has_displacement(const Model& model, const Cuts& cuts, int slot) {
  return has_node(model, slot) && cuts.removed[std::size_t(slot)] == 0;
}
/// Counter that grows with every cut. Data derived from the cuts is rebuilt when it changes.
inline std::size_t cut_version(const Cuts& cuts) {
  return cuts.edges.size() + std::size_t(cuts.sample_count) + std::size_t(cuts.removed_nodes) +
         cuts.excised.size();
}

}  // namespace turgor::lattice

// The mechanics of cells and skin that a blade parted: every piece (pieces.hpp) keeps its share of the cell's
// tissue, as an element on its own corners, of which copies of nodes are unknowns like the nodes themselves.
// Rows of the lattice know nothing of them but that the cell is no longer whole.
#pragma once

#include <span>

#include "turgor/models/lattice/pieces.hpp"
#include "turgor/models/lattice/rows.hpp"
#include "turgor/models/lattice/skin_forces.hpp"
#include "turgor/models/lattice/solid.hpp"

namespace turgor::lattice {

/// Which copies bear tissue: corners of pieces of cells that were whole, whose other corners lead to nodes.
void find_bearing(const Model& model, const State& state, Pieces& pieces);

/// Makes State::parts anew after a cut. Copies that were there before stay where they are, new ones go where
/// the tissue on their side leads.
void part_cells(const Model& model, State& state);

/// Tells the rows beside a slot that something near them is cut.
void mark_rows(const Model& model, State& state, int slot);

/// What parts ask of the nodes and copies that they hang on.
struct PartForces {
  const Model& model;
  NodeArrays nodes;
  const PartsOfCells& parts;
  std::span<CopyShift> copies;
  SolidLaw solid;
  SkinForces skin;

  PartForces(const Model& m, State& s);
  Vec3 u(int corner) const {
    const int copy = corner - slot_count(model.lattice);
    if (copy < 0) return nodes.u(corner);
    const CopyShift& c = copies[std::size_t(copy)];
    return {c.x, c.y, c.z};
  }
  NodeSystem gather(const PartNode& node) const;
  /// The nodes among [slot, slot + count), the copies of these; the copies of layer k.
  std::span<const PartNode> nodes_of(int slot, int count) const;
  std::span<const PartNode> copies_of(int slot, int count) const;
  std::span<const PartNode> copies_of(int k) const;
  /// Moves a copy to the minimum of what its parts ask. It weighs nothing.
  void solve(const PartNode& copy) const;

 private:
  /// What a part of skin asks of its corner `at`.
  NodeSystem skin_part(const SkinPart& part, int at) const;
};

}  // namespace turgor::lattice

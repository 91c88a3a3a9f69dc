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
/// the tissue on their side leads: of no other nodes is it asked where they are.
void part_cells(const Model& model, State& state, const BringNodes& bring = {});

/// Tells the rows beside a slot that something near them is cut.
void mark_rows(const Model& model, State& state, int slot);

/// What parts ask of one of the nodes and copies that they hang on, by plain pointers.
struct PartElements {
  NodeArrays nodes;
  int slots;
  CopyShift* copies;
  const CellPart* cells;
  const SkinPart* skin_parts;
  const PartUse* uses;
  const SkinTriangle* triangles;
  SolidLaw solid;
  SkinForces skin;

  TURGOR_HD Vec3 u(int corner) const {
    if (corner < slots) return nodes.u(corner);
    const CopyShift& c = copies[corner - slots];
    return {c.x, c.y, c.z};
  }
  TURGOR_HD NodeSystem gather(const PartNode& node) const;
  /// Moves a copy to the minimum of what its parts ask. It weighs nothing.
  TURGOR_HD void solve(const PartNode& copy) const;

 private:
  TURGOR_HD NodeSystem skin_part(const SkinPart& part, int at) const;
};

/// What parts ask of the nodes and copies that they hang on.
struct PartForces {
  NodeArrays nodes;
  const PartsOfCells& parts;
  PartElements elements;

  PartForces(const Model& m, State& s);
  NodeSystem gather(const PartNode& node) const { return elements.gather(node); }
  /// The nodes among [slot, slot + count), the copies of these; the copies of layer k.
  std::span<const PartNode> nodes_of(int slot, int count) const;
  std::span<const PartNode> copies_of(int slot, int count) const;
  std::span<const PartNode> copies_of(int k) const;
  void solve(const PartNode& copy) const { elements.solve(copy); }
};

/// What a part of skin asks of its corner `at`.
TURGOR_HD inline NodeSystem PartElements::skin_part(const SkinPart& part, int at) const {
  const SkinTriangle& t = triangles[part.triangle];
  const Vec3 places[3] = {{}, t.edge1, t.edge2};
  const int b = (at + 1) % 3, c = (at + 2) % 3;
  const Vec3 here = u(part.corner[at]) + places[at];
  const Vec3 edge1 = u(part.corner[b]) + places[b] - here, edge2 = u(part.corner[c]) + places[c] - here;
  NodeSystem s;
  if (skin.law == SkinLaw::kFibre) {
    add_skin_fibre(s, edge1, edge2, {t.along[at], t.along[b], t.along[c]},
                   {t.across[at], t.across[b], t.across[c]}, t.area, skin.fibre);
  } else {
    const Real rest = skin.rest_ratio * t.area;
    add_skin_area(s, {}, edge1, edge2, rest, skin.stiffness / rest, skin.amplification);
  }
  s.f = s.f * part.share;
  for (Real* entry : {&s.xx, &s.yy, &s.zz, &s.xy, &s.xz, &s.yz}) *entry *= part.share;
  return s;
}

TURGOR_HD inline NodeSystem PartElements::gather(const PartNode& node) const {
  NodeSystem s;
  s.f -= node.pull;
  const Vec3 here = u(node.corner);
  for (int n = node.first; n < node.first + node.count; n++) {
    const PartUse use = uses[n];
    if (use.part < 0) {
      add(s, skin_part(skin_parts[-1 - use.part], use.at));
      continue;
    }
    const CellPart& cell = cells[use.part];
    Vec3 d[kCellCorners];
    for (int c = 0; c < kCellCorners; c++) d[c] = u(cell.corner[std::size_t(c)]) - here;
    add_cell(s, cell_gradient(d, use.at, solid.slope), use.at, solid, cell.young);
  }
  return s;
}

TURGOR_HD inline void PartElements::solve(const PartNode& copy) const {
  constexpr Real kWeightless = 1e3f;  // mobility, by stiffness
  CopyShift& at = copies[copy.corner - slots];
  if (nodes.w[copy.slot] == 0) {
    const Vec3 held = nodes.u(copy.slot);
    at = {held.x, held.y, held.z};
    return;
  }
  const NodeSystem s = gather(copy);
  const Vec3 way = newton_step(s, {}, kWeightless / nonzero((s.xx + s.yy + s.zz) / 3));
  at = {at.x + way.x, at.y + way.y, at.z + way.z};
}

}  // namespace turgor::lattice

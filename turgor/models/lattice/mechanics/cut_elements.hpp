// The mechanics of cells and skin that a blade parted: every piece (fragments.hpp) keeps its share of the
// cell's tissue, as an element on its own corners, of which copies of nodes are unknowns like the nodes
// themselves. Rows of the lattice know nothing of them but that the cell is no longer whole.
#pragma once

#include <span>

#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Which copies bear tissue: corners of pieces of cells that were whole, whose other corners lead to nodes.
void find_bearing(const Model& model, const State& state, Fragments& pieces);

/// Makes State::parts anew after a cut. Copies that were there before stay where they are, new ones go where
/// the tissue on their side leads: of no other nodes is it asked where they are.
void build_cut_elements(const Model& model, State& state, const DownloadNodes& bring = {});

/// Tells the rows beside a slot that something near them is cut.
void mark_rows(const Model& model, State& state, int slot);

/// What parts ask of one of the nodes and copies that they hang on, by plain pointers.
struct CutElementView {
  NodeArrays nodes;
  int slots;
  VirtualNodeShift* virtual_nodes;
  const CutCellElement* cells;
  const CutSkinElement* cut_skin_elements;
  const NodeElement* uses;
  const SkinTriangle* triangles;
  SolidLaw solid;
  SkinForces skin;

  TURGOR_HD Vec3 u(int corner) const {
    if (corner < slots) return nodes.u(corner);
    const VirtualNodeShift& c = virtual_nodes[corner - slots];
    return {c.x, c.y, c.z};
  }
  TURGOR_HD NodeSystem gather(const ElementNode& node) const;
  /// Moves a copy to the minimum of what its parts ask. It weighs nothing.
  TURGOR_HD void solve(const ElementNode& copy) const;

 private:
  TURGOR_HD NodeSystem skin_part(const CutSkinElement& part, int at) const;
};

/// What parts ask of the nodes and copies that they hang on.
struct CutElementForces {
  NodeArrays nodes;
  const CutElements& parts;
  CutElementView elements;

  CutElementForces(const Model& m, State& s);
  NodeSystem gather(const ElementNode& node) const { return elements.gather(node); }
  /// The nodes among [slot, slot + count), the copies of these; the copies of layer k.
  std::span<const ElementNode> nodes_of(int slot, int count) const;
  std::span<const ElementNode> virtual_nodes_of(int slot, int count) const;
  std::span<const ElementNode> virtual_nodes_of(int k) const;
  void solve(const ElementNode& copy) const { elements.solve(copy); }
};

/// What a part of skin asks of its corner `at`.
TURGOR_HD inline NodeSystem CutElementView::skin_part(const CutSkinElement& part, int at) const {
  const SkinTriangle& t = triangles[part.triangle];
  const Vec3 places[3] = {{}, t.edge1, t.edge2};
  const int b = (at + 1) % 3, c = (at + 2) % 3;
  const Vec3 here = u(part.corner[at]) + places[at];
  const Vec3 edge1 = u(part.corner[b]) + places[b] - here, edge2 = u(part.corner[c]) + places[c] - here;
  NodeSystem s;
  if (skin.law == SkinLaw::kFiber) {
    add_skin_fiber(s, edge1, edge2, {t.along[at], t.along[b], t.along[c]},
                   {t.across[at], t.across[b], t.across[c]}, t.area, skin.fiber);
  } else {
    const Real rest = skin.rest_ratio * t.area;
    add_skin_area(s, {}, edge1, edge2, rest, skin.stiffness / rest, skin.amplification);
  }
  s.f = s.f * part.share;
  for (Real* entry : {&s.xx, &s.yy, &s.zz, &s.xy, &s.xz, &s.yz}) *entry *= part.share;
  return s;
}

TURGOR_HD inline NodeSystem CutElementView::gather(const ElementNode& node) const {
  NodeSystem s;
  s.f -= node.pull;
  const Vec3 here = u(node.corner);
  for (int n = node.first; n < node.first + node.count; n++) {
    const NodeElement use = uses[n];
    if (use.part < 0) {
      add(s, skin_part(cut_skin_elements[-1 - use.part], use.at));
      continue;
    }
    const CutCellElement& cell = cells[use.part];
    Vec3 d[kCellCorners];
    for (int c = 0; c < kCellCorners; c++) d[c] = u(cell.corner[std::size_t(c)]) - here;
    add_cell(s, cell_gradient(d, use.at, solid.slope), use.at, solid, cell.young);
  }
  return s;
}

TURGOR_HD inline void CutElementView::solve(const ElementNode& copy) const {
  constexpr Real kWeightless = 1e3f;  // mobility, by stiffness
  VirtualNodeShift& at = virtual_nodes[copy.corner - slots];
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

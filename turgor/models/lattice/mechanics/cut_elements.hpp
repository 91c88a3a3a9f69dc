// Forces of cut-cell and cut-skin elements. Each fragment of a cut cell is an element with the fragment's
// share of the modulus. Its corners are nodes or virtual nodes, and virtual nodes are unknowns like nodes.
// Topology of the elements is in cutting/cut_topology.hpp. [Molino et al. 2004; Wang et al. 2014]
#pragma once

#include <memory>
#include <span>

#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/mechanics/solid.hpp"
#include "turgor/models/lattice/model/rows.hpp"

namespace turgor::lattice {

/// Cut elements as plain pointers, for host and device.
struct CutElementView {
  NodeArrays nodes;
  int slots;
  VirtualNodeDisplacement* virtual_nodes;
  const CutCellElement* cells;
  const CutSkinElement* cut_skin_elements;
  const NodeElementReference* references;
  const SkinTriangle* triangles;
  const SkinPatch* patches;
  const std::uint32_t* center;  // Anatomy::cell_center; null without partial cells
  SolidLaw solid;
  SkinForces skin;

  TURGOR_HD Vec3 u(int corner) const {
    if (corner < slots) return nodes.u(corner);
    const VirtualNodeDisplacement& c = virtual_nodes[corner - slots];
    return {c.x, c.y, c.z};
  }
  /// Force and Hessian of all cut elements at one of their nodes.
  TURGOR_HD NodeSystem gather(const ElementNode& node) const {
    return gather(node, [this](NodeSystem& s, const CellGradient& u, int at, const CutCellElement& cell) {
      add_cell(s, u, at, solid, cell.young);
    });
  }
  /// The same with the law of a cell as a function.
  template <class AddCell>
  TURGOR_HD NodeSystem gather(const ElementNode& node, const AddCell& add_cell_of) const;
  /// Moves a virtual node to the minimum of the energy of its elements. A virtual node has no mass.
  TURGOR_HD void solve(const ElementNode& virtual_node) const {
    solve(virtual_node, [this](const ElementNode& node) { return gather(node); });
  }
  template <class Gather>
  TURGOR_HD void solve(const ElementNode& virtual_node, const Gather& gather_of) const;
  /// Largest growth of the exponents of cut skin at a node that moves by d; exponential law.
  TURGOR_HD Real largest_growth(const ElementNode& node, Vec3 d) const;
  /// Moves a virtual node of a free node by one Newton step. `s`: all forces on it.
  TURGOR_HD void move(const ElementNode& virtual_node, const NodeSystem& s) const;

 private:
  /// Deformed edges of a cut-skin element from its corner `at`, and the coefficients of F d in this order.
  struct SkinCorner {
    Vec3 edge1, edge2, along, across;
  };
  TURGOR_HD SkinCorner skin_corner(const CutSkinElement& element, int at) const;
  TURGOR_HD NodeSystem skin_element(const CutSkinElement& element, int at) const;
};

struct CellLawView;

/// Cut elements of a state on the host.
struct CutElementForces {
  NodeArrays nodes;
  const CutElements& cut_elements;
  CutElementView view;
  std::shared_ptr<const CellLawView> laws;  // null: all cells follow SolidLaw

  CutElementForces(const Model& m, State& s);
  NodeSystem gather(const ElementNode& node) const { return laws ? gather_laws(node) : view.gather(node); }
  /// Element nodes with slots in [slot, slot + count); virtual nodes of these slots; virtual nodes of layer
  /// k.
  std::span<const ElementNode> nodes_of(int slot, int count) const;
  std::span<const ElementNode> virtual_nodes_of(int slot, int count) const;
  std::span<const ElementNode> virtual_nodes_of(int k) const;
  void solve(const ElementNode& virtual_node) const {
    view.solve(virtual_node, [this](const ElementNode& node) { return gather(node); });
  }

 private:
  NodeSystem gather_laws(const ElementNode& node) const;
};

/// A system times a factor.
TURGOR_HD inline NodeSystem scaled(NodeSystem s, Real by) {
  s.f = s.f * by;
  for (Real* entry : {&s.xx, &s.yy, &s.zz, &s.xy, &s.xz, &s.yz}) *entry *= by;
  return s;
}

TURGOR_HD inline CutElementView::SkinCorner CutElementView::skin_corner(const CutSkinElement& element,
                                                                        int at) const {
  const SkinTriangle& t = triangles[element.triangle];
  const Vec3 rest_position[3] = {{}, t.edge1, t.edge2};
  const int b = (at + 1) % 3, c = (at + 2) % 3;
  const Vec3 x0 = u(element.corner[at]) + rest_position[at];
  return {u(element.corner[b]) + rest_position[b] - x0,
          u(element.corner[c]) + rest_position[c] - x0,
          {t.along[at], t.along[b], t.along[c]},
          {t.across[at], t.across[b], t.across[c]}};
}

/// Force and Hessian of a cut-skin element at its corner `at`: those of the whole triangle times the area
/// share.
TURGOR_HD inline NodeSystem CutElementView::skin_element(const CutSkinElement& element, int at) const {
  const SkinTriangle& t = triangles[element.triangle];
  const auto [edge1, edge2, along, across] = skin_corner(element, at);
  // law of the whole triangle
  NodeSystem s;
  if (skin.law == SkinLaw::kFiber) {
    add_skin_fiber(s, edge1, edge2, along, across, t.area, skin.fiber);
  } else if (skin.law == SkinLaw::kExponential) {
    add_skin_exponential(s, edge1, edge2, along, across, t.area, skin.exponential);
  } else {
    const Real rest = skin.rest_ratio * t.area;
    add_skin_area(s, {}, edge1, edge2, rest, skin.stiffness / rest, skin.amplification);
  }
  return scaled(s, element.share);
}

TURGOR_HD inline Real CutElementView::largest_growth(const ElementNode& node, Vec3 d) const {
  Real most = 0;
  for (int n = node.first; n < node.first + node.count; n++) {
    const NodeElementReference reference = references[n];
    if (reference.element >= 0) continue;
    const auto [edge1, edge2, along, across] =
        skin_corner(cut_skin_elements[-1 - reference.element], reference.at);
    const Real growth = skin_exponent_growth(edge1, edge2, along, across, skin.exponential, d);
    most = growth > most ? growth : most;
  }
  return most;
}

template <class AddCell>
TURGOR_HD inline NodeSystem CutElementView::gather(const ElementNode& node,
                                                   const AddCell& add_cell_of) const {
  NodeSystem s;
  s.f -= node.prestress_force;
  const Vec3 x0 = u(node.corner);
  for (int n = node.first; n < node.first + node.count; n++) {
    // cut-skin element
    const NodeElementReference reference = references[n];
    if (reference.element < 0) {
      add(s, skin_element(cut_skin_elements[-1 - reference.element], reference.at));
      continue;
    }
    // cut-cell element
    const CutCellElement& cell = cells[reference.element];
    Vec3 d[kCellCorners];
    for (int c = 0; c < kCellCorners; c++) d[c] = u(cell.corner[std::size_t(c)]) - x0;
    if (const CellCenter of{center ? center[cell.slot] : 0}; of.bits != 0) {
      const Vec3 point = of.in_half_cells();
      add_cell(s, cell_gradient_at(d, reference.at, solid.slope, point),
               shape_gradient(reference.at, solid.slope, point), solid, cell.young);
    } else {
      add_cell_of(s, cell_gradient(d, reference.at, solid.slope), reference.at, cell);
    }
    if (cell.patch >= 0)
      add(s, scaled(skin.patch_system(d, reference.at, patches[cell.patch]), cell.skin_share));
  }
  return s;
}

/// Mobility of a virtual node, which has no mass [m/N].
TURGOR_HD inline Real weightless_mobility(const NodeSystem& s) {
  constexpr Real kWeightless = 1e3f;  // h²/m times the stiffness; large, so that inertia is negligible
  return kWeightless / nonzero((s.xx + s.yy + s.zz) / 3);
}

TURGOR_HD inline void CutElementView::move(const ElementNode& virtual_node, const NodeSystem& s) const {
  const Vec3 step = newton_step(s, {}, weightless_mobility(s));
  const Real share =
      skin.law == SkinLaw::kExponential ? skin_step_share(largest_growth(virtual_node, step)) : Real(1);
  virtual_nodes[virtual_node.corner - slots].move(step * share);
}

template <class Gather>
TURGOR_HD inline void CutElementView::solve(const ElementNode& virtual_node, const Gather& gather_of) const {
  // fixed node: the virtual node follows it
  if (nodes.w[virtual_node.slot] == 0) {
    const Vec3 held = nodes.u(virtual_node.slot);
    virtual_nodes[virtual_node.corner - slots] = {held.x, held.y, held.z};
    return;
  }
  move(virtual_node, gather_of(virtual_node));
}

}  // namespace turgor::lattice

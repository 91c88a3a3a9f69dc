#include "turgor/models/lattice/mechanics/cut_elements.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"

namespace turgor::lattice {

CutElementForces::CutElementForces(const Model& m, State& s)
    : nodes(node_arrays(m, s)),
      cut_elements(s.cut_elements),
      view{nodes,
           slot_count(m.anatomy.lattice),
           s.motion.virtual_u.data(),
           s.cut_elements.cells.data(),
           s.cut_elements.skin.data(),
           s.cut_elements.references.data(),
           m.anatomy.skin.triangles.data(),
           m.anatomy.skin.patches.data(),
           m.anatomy.cell_center.empty() ? nullptr : m.anatomy.cell_center.data(),
           solid_law(m.anatomy.lattice.spacing, m.params.tissue.poisson),
           SkinForces(m)} {
  if (const CellLawView of = cell_law_view(m, s); of.has_laws()) laws = std::make_shared<CellLawView>(of);
}

NodeSystem CutElementForces::gather_laws(const ElementNode& node) const {
  return view.gather(node, [this](NodeSystem& s, const CellGradient& u, int at, const CutCellElement& cell) {
    add_law_cell(s, u, at, *laws, cell.slot, cell.young);
  });
}

namespace {
std::span<const ElementNode> between(const std::vector<ElementNode>& nodes, int slot, int count) {
  const auto before = [](const ElementNode& n, int s) { return n.slot < s; };
  const auto begin = std::lower_bound(nodes.begin(), nodes.end(), slot, before);
  return {begin, std::lower_bound(begin, nodes.end(), slot + count, before)};
}
}  // namespace

std::span<const ElementNode> CutElementForces::nodes_of(int slot, int count) const {
  return between(cut_elements.nodes, slot, count);
}

std::span<const ElementNode> CutElementForces::virtual_nodes_of(int slot, int count) const {
  return between(cut_elements.virtual_nodes, slot, count);
}

std::span<const ElementNode> CutElementForces::virtual_nodes_of(int k) const {
  if (cut_elements.layer_begin.empty()) return {};
  TURGOR_CHECK(is_index(k + 1, cut_elements.layer_begin.size()), "the layer belongs to the body");
  const auto begin = std::size_t(cut_elements.layer_begin[std::size_t(k)]),
             end = std::size_t(cut_elements.layer_begin[std::size_t(k) + 1]);
  return std::span(cut_elements.virtual_nodes).subspan(begin, end - begin);
}

}  // namespace turgor::lattice

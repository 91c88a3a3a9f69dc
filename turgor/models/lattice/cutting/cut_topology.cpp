#include "turgor/models/lattice/cutting/cut_topology.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/crack_tips.hpp"
#include "turgor/models/lattice/cutting/element_fragments.hpp"
#include "turgor/models/lattice/cutting/fragment_shares.hpp"
#include "turgor/models/lattice/cutting/loose_rim.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"

namespace turgor::lattice {

namespace {

/// Volume fractions by cell, computed at the first request.
struct VolumeFractionCache {
  const Fragments& fragments;
  const Cuts& cuts;
  std::vector<std::optional<Shares>> known;

  VolumeFractionCache(const Fragments& p, const Cuts& c) : fragments(p), cuts(c), known(p.cells.size()) {}
  const Shares& operator()(const CutCell& cell) {
    std::optional<Shares>& found = known[std::size_t(&cell - fragments.cells.data())];
    if (!found) found = shares_of(fragments, cuts, cell);
    return *found;
  }
};

/// True if a fragment at a crack tip left the body.
bool is_excised(const Fragments& fragments, const CutCell& cell, const CrackTip& tip) {
  const auto excised = [&](int n) { return fragments.all[std::size_t(cell.first_fragment + n)].excised; };
  return excised(tip.left) || excised(tip.right);
}

/// Skin of the elements of a cut cell.
struct CutPatch {
  int patch = -1;
  std::vector<Real> shares;  // by fragment; empty without a patch

  CutPatch(const Model& model, const Cuts& cuts, const Fragments& fragments, const CutCell& cell)
      : patch(patch_of_cell(model.anatomy.skin, cell.slot)) {
    if (patch >= 0)
      shares = patch_shares(model, cuts, fragments, cell, model.anatomy.skin.patches[std::size_t(patch)]);
  }
  Real share(int fragment) const { return shares.empty() ? Real(0) : shares[std::size_t(fragment)]; }
};

/// Adds the bridges and fragments of a cut cell that are elements, and marks the cell as cut.
void add_cell(const Model& model, State& state, const Fragments& fragments,
              VolumeFractionCache& cached_shares, const CutCell& cell) {
  std::vector<int> elements;  // fragments of the cell
  for (int p = 0; p < cell.fragment_count; p++)
    if (can_be_element(model, state.cuts, fragments, fragments.all[std::size_t(cell.first_fragment + p)]))
      elements.push_back(p);
  if (elements.empty()) return;
  state.cuts.cut[std::size_t(cell.slot)] |= kCutCell;
  mark_rows(model, state.cuts, cell.slot);
  // an element is added if all its corners are solved for
  const Real young = model.anatomy.cell_young[std::size_t(cell.slot)];
  const Shares& shares = cached_shares(cell);
  const CutPatch skin(model, state.cuts, fragments, cell);
  const auto add = [&](const std::array<int, 8>& corners, Real modulus, Real skin_share) {
    if (has_all_unknowns(fragments, corners))
      state.cut_elements.cells.push_back({corners, modulus, cell.slot, skin.patch, skin_share});
  };
  for (int t = 0; t < cell.tip_count; t++) {
    const CrackTip& tip = fragments.tips[std::size_t(cell.first_tip + t)];
    if (is_excised(fragments, cell, tip)) continue;
    const Real bridge = shares.bridges[std::size_t(t)];
    add(bridge_corners(model, state.cuts, fragments, cell, tip),
        young * bridge * (shares.of[std::size_t(tip.left)] + shares.of[std::size_t(tip.right)]),
        bridge * (skin.share(tip.left) + skin.share(tip.right)));
  }
  for (const int p : elements) {
    const Real parted = shares.parted[std::size_t(p)];
    add(fragments.all[std::size_t(cell.first_fragment + p)].corner,
        young * parted * shares.of[std::size_t(p)], parted * skin.share(p));
  }
}

void add_skin_elements(const Model& model, State& state, const Fragments& fragments,
                       VolumeFractionCache& cached_shares, int t) {
  constexpr int kSubdivisions = 8;
  // cell of the triangle
  const Lattice& l = model.anatomy.lattice;
  Int3 node[3], low = l.size - Int3{2, 2, 2};
  for (int c = 0; c < 3; c++) {
    node[c] = slot_node(l, model.anatomy.skin.triangles[std::size_t(t)].vertex[c]);
    low = min(low, node[c]);
  }
  const CutCell* cell = find_cell(fragments, node_slot(l, low));
  if (cell == nullptr) return;
  // sample points of the triangle in each fragment
  const Vec3 local[3] = {Vec3(node[0] - low), Vec3(node[1] - low), Vec3(node[2] - low)};
  const std::vector<int> count = count_points(fragments, state.cuts, *cell, local, kSubdivisions);
  const Shares& shares = cached_shares(*cell);
  const auto add = [&](const std::array<int, 8>& corners, Real share) {
    CutSkinElement element{.triangle = t, .corner = {}, .share = share};
    bool has_all_unknowns = element.share > 0;
    for (int c = 0; c < 3; c++) {
      const Int3 at = node[c] - low;
      element.corner[c] = corners[std::size_t(corner_of(at))];
      has_all_unknowns = has_all_unknowns && has_unknowns(model, state.cuts, fragments, element.corner[c]);
    }
    if (has_all_unknowns) state.cut_elements.skin.push_back(element);
  };
  const auto share = [&](int fragment) {
    return Real(count[std::size_t(fragment)]) / (kSubdivisions * kSubdivisions);
  };
  // bridges at crack tips
  for (int b = 0; b < cell->tip_count; b++) {
    const CrackTip& tip = fragments.tips[std::size_t(cell->first_tip + b)];
    if (is_excised(fragments, *cell, tip)) continue;
    add(bridge_corners(model, state.cuts, fragments, *cell, tip),
        shares.bridges[std::size_t(b)] * (share(tip.left) + share(tip.right)));
  }
  // fragments
  for (int p = 0; p < cell->fragment_count; p++)
    if (const Fragment& fragment = fragments.all[std::size_t(cell->first_fragment + p)]; !fragment.excised)
      add(fragment.corner, shares.parted[std::size_t(p)] * share(p));
}

/// Area of a patch times the weight of a corner of its cell at its center [m²].
double area_at_corner(const SkinPatch& patch, int corner) {
  const Vec3 at = (patch.point + Vec3{1, 1, 1}) * Real(0.5);
  return double(patch.area) * double(trilinear(at)[std::size_t(corner)]);
}

/// Moves prestress from skin nodes to their virtual nodes, in proportion to skin area.
void share_prestress(const Model& model, CutElements& elements) {
  const Skin& skin = model.anatomy.skin;
  const int slots = slot_count(model.anatomy.lattice);
  TURGOR_CHECK(is_ascending(elements.nodes, &ElementNode::slot), "element nodes ascend by slot");
  for (ElementNode& virtual_node : elements.virtual_nodes) {
    // skin at the node
    const auto at = std::size_t(std::lower_bound(skin.nodes.begin(), skin.nodes.end(), virtual_node.slot) -
                                skin.nodes.begin());
    if (at == skin.nodes.size() || skin.nodes[at] != virtual_node.slot) continue;
    const auto row = std::size_t(virtual_node.slot / model.anatomy.lattice.half);
    const int first = model.vbd.corner_begin[std::size_t(skin.row_begin[row])];
    // skin area of the node in the CT, and of its virtual node
    double whole = 0, own = 0;
    for (int c = model.vbd.corner_begin[at]; c < model.vbd.corner_begin[at + 1]; c++) {
      const auto lanes = std::size_t(model.vbd.lanes_begin[row] + (c - first) / kSkinLanes);
      const int lane = (c - first) % kSkinLanes;
      whole += skin.patches.empty()
                   ? double(model.vbd.corners[lanes].area[lane])
                   : area_at_corner(skin.patches[std::size_t(model.vbd.patch_corners[lanes].patch[lane])],
                                    model.vbd.patch_corners[lanes].at[lane]);
    }
    for (int u = virtual_node.first; u < virtual_node.first + virtual_node.count; u++) {
      const auto [element, corner] = elements.references[std::size_t(u)];
      if (element < 0)
        own += double(elements.skin[std::size_t(-1 - element)].share) *
               skin.triangles[std::size_t(elements.skin[std::size_t(-1 - element)].triangle)].area;
      else if (const CutCellElement& cell = elements.cells[std::size_t(element)]; cell.patch >= 0)
        own += double(cell.skin_share) * area_at_corner(skin.patches[std::size_t(cell.patch)], corner);
    }
    // prestress of the virtual node, taken from the node
    if (!skin.patches.empty() && !(whole > 0)) continue;
    TURGOR_CHECK(whole > 0, "skin at a node has an area in the CT");
    virtual_node.prestress_force = model.prestress_force[at] * Real(own / whole);
    const auto node = std::lower_bound(elements.nodes.begin(), elements.nodes.end(), virtual_node.slot,
                                       [](const ElementNode& n, int slot) { return n.slot < slot; });
    if (node != elements.nodes.end() && node->corner == virtual_node.slot && virtual_node.slot < slots)
      node->prestress_force -= virtual_node.prestress_force;
  }
}

/// Cancels the prestress of removed skin nodes, which no element balances.
void cancel_prestress_of_removed(const Model& model, const Cuts& cuts, CutElements& elements) {
  const std::size_t count = elements.nodes.size();
  for (std::size_t at = 0; at < model.prestress_force.size(); at++) {
    const int slot = model.anatomy.skin.nodes[at];
    if (cuts.removed[std::size_t(slot)] == 0) continue;
    const auto end = elements.nodes.begin() + std::ptrdiff_t(count);
    const auto node = std::lower_bound(elements.nodes.begin(), end, slot,
                                       [](const ElementNode& n, int s) { return n.corner < s; });
    if (node != end && node->corner == slot)
      node->prestress_force = -model.prestress_force[at];
    else
      elements.nodes.push_back({.corner = slot, .slot = slot, .prestress_force = -model.prestress_force[at]});
  }
  std::sort(elements.nodes.begin(), elements.nodes.end(),
            [](const ElementNode& a, const ElementNode& b) { return a.corner < b.corner; });
}

/// Collects the nodes and virtual nodes of all elements, and the references from each node to its elements.
void add_nodes(const Model& model, const Fragments& fragments, CutElements& elements) {
  const int slots = slot_count(model.anatomy.lattice);
  // references, sorted by node
  std::vector<std::pair<int, NodeElementReference>> references;
  for (std::size_t p = 0; p < elements.cells.size(); p++)
    for (int n = 0; n < kCellCorners; n++)
      references.push_back({elements.cells[p].corner[std::size_t(n)], {int(p), n}});
  for (std::size_t s = 0; s < elements.skin.size(); s++)
    for (int n = 0; n < 3; n++) references.push_back({elements.skin[s].corner[n], {-1 - int(s), n}});
  std::stable_sort(references.begin(), references.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  // nodes
  for (const auto& [corner, reference] : references) {
    auto& list = corner < slots ? elements.nodes : elements.virtual_nodes;
    if (list.empty() || list.back().corner != corner)
      list.push_back(
          {.corner = corner,
           .slot = corner < slots ? corner : fragments.virtual_nodes[std::size_t(corner - slots)].slot,
           .first = int(elements.references.size())});
    list.back().count++;
    elements.references.push_back(reference);
  }
  // first virtual node of each layer
  TURGOR_CHECK(is_ascending(elements.virtual_nodes, &ElementNode::slot), "virtual nodes ascend by slot");
  for (int k = 0; k <= model.anatomy.lattice.size.z; k++)
    elements.layer_begin.push_back(
        int(std::lower_bound(elements.virtual_nodes.begin(), elements.virtual_nodes.end(),
                             row_slot(model.anatomy.lattice, -1, k),
                             [](const ElementNode& n, int slot) { return n.slot < slot; }) -
            elements.virtual_nodes.begin()));
}

/// Sets the displacements of virtual nodes after a cut. Those from before the cut keep theirs; they are
/// matched by slot and lowest fine node. New ones are evaluated from their fit.
void update_virtual_nodes(const Model& model, State& state, const Fragments& fragments,
                          const DownloadNodes& download) {
  // virtual nodes from before the cut
  const std::vector<VirtualNodeDisplacement> before = std::exchange(state.motion.virtual_u, {});
  std::vector<VirtualNodeDisplacement> now(fragments.virtual_nodes.size());
  const auto key = [](const VirtualNode& c) { return std::pair(c.slot, c.lowest_node); };
  const std::vector<std::pair<int, std::uint64_t>> known =
      std::exchange(state.cut_elements.virtual_node_keys, {});
  TURGOR_CHECK(is_ascending(known, [](const std::pair<int, std::uint64_t>& k) { return k.first; }),
               "keys of virtual nodes ascend by slot");
  const auto corner = [&](std::size_t virtual_node) {
    return slot_count(model.anatomy.lattice) + int(virtual_node);
  };
  std::vector<std::size_t> fresh;
  for (std::size_t c = 0; c < fragments.virtual_nodes.size(); c++) {
    const auto at = std::find(std::lower_bound(known.begin(), known.end(),
                                               std::pair(fragments.virtual_nodes[c].slot, std::uint64_t(0))),
                              known.end(), key(fragments.virtual_nodes[c]));
    state.cut_elements.virtual_node_keys.push_back(key(fragments.virtual_nodes[c]));
    if (at != known.end() && before.size() == known.size())
      now[c] = before[std::size_t(at - known.begin())];
    else
      fresh.push_back(c);
  }
  // download the nodes that determine new virtual nodes
  if (download && !fresh.empty()) {
    std::vector<int> support;
    for (const std::size_t c : fresh)
      add_support_nodes(model, state.cuts, state.motion.virtual_u, fragments, corner(c), support);
    sort_unique(support);
    download(support);
  }
  // displacements of new virtual nodes
  for (const std::size_t c : fresh) {
    const Vec3 u = corner_displacement(model, state, fragments, corner(c));
    now[c] = {u.x, u.y, u.z};
  }
  state.motion.virtual_u = state.motion.virtual_u_before = std::move(now);
}

/// Builds the elements of cells that blades have cut, with their virtual nodes and prestress.
void build_elements_of_blades(const Model& model, State& state, const DownloadNodes& download) {
  // virtual nodes of the fragments
  const Fragments& fragments = *state.cuts.fragments;
  TURGOR_CHECK(fragments.version == cut_version(state.cuts), "the fragments are those of the current cuts");
  update_virtual_nodes(model, state, fragments, download);
  // rebuild cut cells and skin elements
  CutElements& elements = state.cut_elements;
  elements = {.virtual_node_keys = std::move(elements.virtual_node_keys)};
  VolumeFractionCache cached_shares(fragments, state.cuts);
  for (const CutCell& cell : fragments.cells)
    if (is_cut_cell(model, state.cuts, fragments, cell))
      add_cell(model, state, fragments, cached_shares, cell);
  if (!model.anatomy.skin.patches.empty()) cut_skin(model, state.cuts);
  for (std::size_t t = 0; t < state.cuts.skin_cut.size() && model.anatomy.skin.patches.empty(); t++)
    if (state.cuts.skin_cut[t]) add_skin_elements(model, state, fragments, cached_shares, int(t));
  // virtual nodes and their layers
  add_nodes(model, fragments, elements);
  TURGOR_CHECK(is_csr(elements.layer_begin, elements.virtual_nodes.size()),
               "the layers cover all virtual nodes");
  // prestress of the cut skin
  if (!model.prestress_force.empty()) share_prestress(model, elements);
}

}  // namespace

void mark_rows(const Model& model, Cuts& cuts, int slot) {
  TURGOR_CHECK(is_index(slot, model.anatomy.tissue.size()), "an edge starts at a slot of the lattice");
  const int stride = row_stride(model.anatomy.lattice), layer = layer_stride(model.anatomy.lattice);
  for (int dk = -1; dk <= 1; dk++)
    for (int dj = -1; dj <= 1; dj++)
      cuts.row_cut[std::size_t((slot + dk * layer + dj * stride) / stride)] = 1;
}

void build_cut_elements(const Model& model, State& state, const DownloadNodes& download) {
  store_fragments(model, state.cuts);
  if (!has_cut_elements(model)) return;
  if (!state.cuts.edges.empty()) build_elements_of_blades(model, state, download);
  // rim nodes beside removed nodes and cut cells
  remove_loose_rim(model, state);
  if (!model.anatomy.skin.patches.empty()) cancel_prestress_of_removed(model, state.cuts, state.cut_elements);
}

void renew_prestress(const Model& model, const Cuts& cuts, CutElements& elements) {
  if (model.prestress_force.empty()) return;
  for (std::vector<ElementNode>* list : {&elements.nodes, &elements.virtual_nodes})
    for (ElementNode& node : *list) node.prestress_force = {};
  share_prestress(model, elements);
  if (!model.anatomy.skin.patches.empty()) cancel_prestress_of_removed(model, cuts, elements);
}

}  // namespace turgor::lattice

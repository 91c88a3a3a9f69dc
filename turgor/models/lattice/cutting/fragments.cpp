#include "turgor/models/lattice/cutting/fragments.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/air_labels.hpp"
#include "turgor/models/lattice/cutting/crack_tips.hpp"
#include "turgor/models/lattice/cutting/fragment_stages.hpp"
#include "turgor/models/lattice/cutting/small_components.hpp"
#include "turgor/models/lattice/cutting/virtual_node_fit.hpp"
#include "turgor/models/lattice/cutting/virtual_nodes.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// Collects the cells with a cut edge and all their neighbors.
void find_cells(const Cuts& cuts, Fragments& out) {
  const Lattice& l = out.fine.cells;
  // cells with a cut edge
  std::vector<int> cut, near;
  for (const CutEdge& edge : cuts.edges) {
    const Int3 a = fine_node(out.fine, edge);
    for_cells_of_edge(out.fine, a, a + kFamilies[edge.family],
                      [&](Int3 cell) { cut.push_back(node_slot(l, cell)); });
  }
  sort_unique(cut);
  // and their neighbors
  for (const int slot : cut) {
    const Int3 cell = slot_node(l, slot);
    const Int3 low = max(cell - Int3{1, 1, 1}, Int3{0, 0, 0}),
               high = min(cell + Int3{1, 1, 1}, l.size - Int3{2, 2, 2});
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++) near.push_back(node_slot(l, i, j, k));
  }
  sort_unique(near);
  // allocate labels and cut bits
  const auto per_cell = std::size_t(sub_node_count(out.fine));
  for (const int slot : near) {
    out.cell_index.find_or_add(std::uint64_t(slot));
    out.cells.push_back({.slot = slot,
                         .first_sub_index = out.cells.size() * per_cell,
                         .is_cut = std::binary_search(cut.begin(), cut.end(), slot)});
  }
  out.label.assign(out.cells.size() * per_cell, -1);
  out.cut_bits.assign(out.cells.size() * per_cell, 0);
}

/// Marks the cut edges at the sub-lattice nodes of every cell that contains them.
CutEdgesByCell mark_cut_edges(const Cuts& cuts, Fragments& out) {
  const FineLattice& f = out.fine;
  CutEdgesByCell edges;
  for (std::size_t n = 0; n < cuts.edges.size(); n++) {
    const CutEdge& edge = cuts.edges[n];
    TURGOR_CHECK((edge.sub_index & 7) <= f.subdivisions.x && (edge.sub_index >> 3 & 7) <= f.subdivisions.y &&
                     edge.sub_index >> 6 <= f.subdivisions.z,
                 "a sub-index lies in its cell");
    const Int3 a = fine_node(f, edge);
    // index of the edge, and its bit in each cell
    out.edge_index.find_or_add(fine_edge_key(f, a, edge.family));
    for_cells_of_edge(f, a, a + kFamilies[edge.family], [&](Int3 cell) {
      TURGOR_CHECK(find_cell(out, node_slot(f.cells, cell)) != nullptr,
                   "the cells around a cut edge are listed");
      const CutCell& c = *find_cell(out, node_slot(f.cells, cell));
      const int sub_node = sub_index(f, a - first_of_cell(f, cell));
      out.cut_bits[c.first_sub_index + std::size_t(sub_node)] |= std::uint8_t(1u << edge.family);
      edges.pairs.emplace_back(int(&c - out.cells.data()), int(n));
    });
  }
  std::sort(edges.pairs.begin(), edges.pairs.end());
  return edges;
}

/// True if a partial cell is an element (partial_cells.hpp). Blades divide all of it, also beyond the skin.
bool is_partial_element(const Model& model, const Cuts& cuts, const FineLattice& f, int slot) {
  if (model.anatomy.cell_center.empty() || !(model.anatomy.cell_young[std::size_t(slot)] > 0)) return false;
  const int parity = slot_node(f.cells, slot).x & 1;
  for (int c = 0; c < 8; c++)
    if (is_removed_tissue(model, cuts, slot + slot_offset(f.cells, cell_corner(c), parity))) return false;
  return true;
}

/// Marks the tissue nodes of a sub-lattice: those with positive interpolated node_level, and all nodes of
/// partial cells.
std::array<bool, kMaxSubNodes> solid_sub_nodes(const Model& model, const Cuts& cuts, const FineLattice& f,
                                               int slot) {
  // levels at the cell's corners
  std::array<Real, 8> level;
  const int parity = slot_node(f.cells, slot).x & 1;
  for (int c = 0; c < 8; c++)
    level[std::size_t(c)] = node_level(model, cuts, slot + slot_offset(f.cells, cell_corner(c), parity));
  std::array<bool, kMaxSubNodes> solid{};
  // corners on one side of the skin
  const auto above = std::count_if(level.begin(), level.end(), [](Real l) { return l > 0; });
  if (above == 0) return solid;
  if (above == 8 || is_partial_element(model, cuts, f, slot)) {
    solid.fill(true);
    return solid;
  }
  // sign of the interpolated level
  for_sub_nodes(f, [&](Int3 p) {
    const auto weight = trilinear(Vec3{Real(p.x) / Real(f.subdivisions.x), Real(p.y) / Real(f.subdivisions.y),
                                       Real(p.z) / Real(f.subdivisions.z)});
    Real sum = 0;
    for (std::size_t c = 0; c < 8; c++) sum += weight[c] * level[c];
    solid[std::size_t(sub_index(f, p))] = sum > 0;
  });
  return solid;
}

/// Labels the fragments of a cell by flood fill over its tissue; air keeps -1. Returns the number of
/// fragments.
int label_tissue(const CellSubLattice& sub_lattice, const std::array<bool, kMaxSubNodes>& solid) {
  int count = 0;
  std::vector<Int3> open;
  for_sub_nodes(sub_lattice.fine, [&](Int3 start) {
    // seed: an unlabeled solid sub-node
    const int at = sub_index(sub_lattice.fine, start);
    if (!solid[std::size_t(at)] || sub_lattice.label[at] >= 0) return;
    sub_lattice.label[at] = std::int16_t(count);
    open.assign(1, start);
    // flood fill of its component
    while (!open.empty()) {
      const Int3 p = open.back();
      open.pop_back();
      sub_lattice.for_connected(p, [&](Int3 next, int sub_node) {
        if (!solid[std::size_t(sub_node)] || sub_lattice.label[sub_node] >= 0) return;
        sub_lattice.label[sub_node] = std::int16_t(count);
        open.push_back(next);
      });
    }
    count++;
  });
  TURGOR_CHECK(count <= std::numeric_limits<std::int16_t>::max(), "labels fit 16 bits");
  return count;
}

/// Incision that entered a fragment without separating it: the one with most cut fine edges inside the
/// fragment. -1 if the fragment contains both ends of no cut lattice edge, or no cut fine edge.
int entering_blade(const Cuts& cuts, const Fragments& fragments, const CutEdgesByCell& edges,
                   const CutCell& cell, const CellSubLattice& sub_lattice, int fragment) {
  const FineLattice& f = fragments.fine;
  const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
  const auto has = [&](Int3 local) { return sub_lattice.label[sub_index(f, local)] == fragment; };
  // a cut lattice edge with both ends in the fragment
  bool between_corners = false;
  const int parity = slot_node(f.cells, cell.slot).x & 1;
  for (int c = 0; c < 8; c++)
    for (int n = 0; n < kFamilyCount; n++) {
      if (!(edges_from_corner(c) >> n & 1)) continue;
      const Int3 low = cell_corner(c), high = low + kFamilies[std::size_t(n)];
      if (!has(hadamard(low, f.subdivisions)) || !has(hadamard(high, f.subdivisions))) continue;
      between_corners |= (cuts.cut[std::size_t(cell.slot + slot_offset(f.cells, low, parity))] >> n & 1) != 0;
    }
  if (!between_corners) return -1;
  // cut fine edges in the fragment, per incision
  std::array<int, 256> count{};
  const int index = int(&cell - fragments.cells.data());
  auto at = std::lower_bound(edges.pairs.begin(), edges.pairs.end(), std::pair(index, -1));
  for (; at != edges.pairs.end() && at->first == index; ++at) {
    const CutEdge& edge = cuts.edges[std::size_t(at->second)];
    const Int3 a = fine_node(f, edge) - first;
    if (has(a) && has(a + kFamilies[edge.family])) count[edge.incision]++;
  }
  const auto most = std::max_element(count.begin(), count.end());
  return *most > 0 ? int(most - count.begin()) : -1;
}

/// Splits a fragment by a plane if a blade entered it without separating it. A cell behind the end of the
/// blade joins both sides; a bridge would hold the copy of a node at the end on one side only.
void split_at_crack_tip(const Cuts& cuts, Fragments& fragments, const CutEdgesByCell& edges, CutCell& cell,
                        const CellSubLattice& sub_lattice, int fragment) {
  const int incision = entering_blade(cuts, fragments, edges, cell, sub_lattice, fragment);
  if (incision < 0) return;
  const std::optional<CrackTipPlane> plane = fit_crack_tip_plane(cuts, fragments, edges, cell, incision);
  if (!plane || is_behind_end(cuts, fragments, edges, cell, *plane, std::uint8_t(incision))) return;
  // both sides must have nodes
  const Int3 first = first_of_cell(fragments.fine, slot_node(fragments.fine.cells, cell.slot));
  const auto is_right = [&](Int3 p) {
    return plane->signed_distance(lattice_index(fragments.fine, first + p)) >= 0;
  };
  const auto label = [&](Int3 p) -> std::int16_t& { return sub_lattice.label[sub_index(fragments.fine, p)]; };
  bool any[2] = {false, false};
  for_sub_nodes(fragments.fine, [&](Int3 p) {
    if (label(p) == fragment) any[is_right(p)] = true;
  });
  if (!any[0] || !any[1]) return;
  // the right side becomes a new fragment
  for_sub_nodes(fragments.fine, [&](Int3 p) {
    if (label(p) == fragment && is_right(p)) label(p) = std::int16_t(cell.fragment_count);
  });
  fragments.tips.push_back({*plane, fragment, cell.fragment_count++, std::uint8_t(incision)});
}

/// Lowest fine-node index of a fragment.
std::uint64_t lowest_node(const Fragments& fragments, const CutCell& cell, int fragment) {
  const Int3 first = first_of_cell(fragments.fine, slot_node(fragments.fine.cells, cell.slot));
  std::uint64_t lowest = std::numeric_limits<std::uint64_t>::max();
  for_sub_nodes(fragments.fine, [&](Int3 p) {
    if (fragments.label[cell.first_sub_index + std::size_t(sub_index(fragments.fine, p))] == fragment)
      lowest = std::min(lowest, fine_index(fragments.fine, first + p));
  });
  return lowest;
}

/// True if a fragment has no area in any face of its cell: no square of fine nodes has three corners in it.
bool is_thin(const Fragments& fragments, const CutCell& cell, int fragment) {
  const FineLattice& f = fragments.fine;
  bool found = false;
  const auto has = [&](Int3 p) {
    return fragments.label[cell.first_sub_index + std::size_t(sub_index(f, p))] == fragment;
  };
  for (int axis = 0; axis < 3; axis++) {
    const Int3 u = kFamilies[std::size_t((axis + 1) % 3)], v = kFamilies[std::size_t((axis + 2) % 3)];
    for_sub_nodes(f, [&](Int3 p) {
      if ((p[axis] != 0 && p[axis] != f.subdivisions[axis]) || !in_cell(f, p + u + v)) return;
      found = found || has(p) + has(p + u) + has(p + v) + has(p + u + v) >= 3;
    });
  }
  return !found;
}

/// True if all of a cell is tissue, and no edge in it is cut. It is then one fragment.
bool is_one_fragment(const CutCell& cell, const FineLattice& f, const std::array<bool, kMaxSubNodes>& solid) {
  return !cell.is_cut && std::all_of(solid.begin(), solid.begin() + sub_node_count(f), std::identity());
}

void make_cell_fragments(const Model& model, const Cuts& cuts, const CutEdgesByCell& edges,
                         const EarlierFragments& earlier, Fragments& out) {
  for (std::size_t c = 0; c < out.cells.size(); c++) {
    CutCell& cell = out.cells[c];
    if (const int index = earlier.index(int(c)); index >= 0) {
      copy_cell(*earlier.fragments, index, cell, out);
      continue;
    }
    const CellSubLattice sub_lattice(out, cell);
    // connected components of the tissue
    cell.first_fragment = int(out.all.size());
    const std::array<bool, kMaxSubNodes> solid = solid_sub_nodes(model, cuts, out.fine, cell.slot);
    const bool is_one = is_one_fragment(cell, out.fine, solid);
    if (is_one) std::fill_n(sub_lattice.label, sub_node_count(out.fine), std::int16_t(0));
    cell.fragment_count = is_one ? 1 : label_tissue(sub_lattice, solid);
    // split fragments at crack tips
    cell.first_tip = int(out.tips.size());
    const int found = cell.is_cut ? cell.fragment_count : 0;
    for (int fragment = 0; fragment < found; fragment++)
      split_at_crack_tip(cuts, out, edges, cell, sub_lattice, fragment);
    cell.tip_count = int(out.tips.size()) - cell.first_tip;
    // list fragments; corners are the cell's own nodes until virtual nodes are made
    for (int p = 0; p < cell.fragment_count; p++) {
      const int parity = slot_node(out.fine.cells, cell.slot).x & 1;
      const Int3 corner = slot_node(out.fine.cells, cell.slot);
      Fragment fragment{.cell = int(c),
                        .lowest_node = is_one ? fine_index(out.fine, first_of_cell(out.fine, corner))
                                              : lowest_node(out, cell, p),
                        .thin = !is_one && is_thin(out, cell, p),
                        .corner = {}};
      for (int n = 0; n < 8; n++)
        fragment.corner[std::size_t(n)] = cell.slot + slot_offset(out.fine.cells, cell_corner(n), parity);
      out.all.push_back(fragment);
    }
  }
}

/// Marks the fragments of excised pieces.
void mark_excised(const Cuts& cuts, Fragments& out) {
  if (cuts.excised.empty()) return;
  for (Fragment& fragment : out.all) {
    const CutCell& cell = out.cells[std::size_t(fragment.cell)];
    const Int3 first = first_of_cell(out.fine, slot_node(out.fine.cells, cell.slot));
    const int sub_node = sub_index(out.fine, fine_position(out.fine, fragment.lowest_node) - first);
    fragment.excised =
        std::binary_search(cuts.excised.begin(), cuts.excised.end(), excised_key(cell.slot, sub_node));
  }
}

}  // namespace

Real node_level(const Model& model, const Cuts& cuts, int slot) {
  constexpr Real kLeast = 4, kGas = 500;  // least magnitude, and magnitude at gas and removed nodes [HU]
  const auto s = std::size_t(slot);
  TURGOR_CHECK(is_index(slot, model.anatomy.hu.size()), "a node is a slot of the lattice");
  const Real beyond = Real(model.anatomy.hu[s]) - Real(model.params.tissue.air_max);
  if (!is_body(model.anatomy.tissue[s])) return std::min(beyond, -kLeast);
  if (is_removed_tissue(model, cuts, slot)) return -kGas;
  return beyond < 0 ? kGas : std::max(beyond, kLeast);
}

Fragments make_fragments(const Model& model, const Cuts& cuts, const Fragments* before) {
  Fragments out;
  out.fine = fine_lattice(model);
  out.version = cut_version(cuts);
  if (cuts.edges.empty()) return out;
  // fragments of each cell
  find_cells(cuts, out);
  const EarlierFragments earlier = find_earlier(before, cuts, out);
  const CutEdgesByCell edges = mark_cut_edges(cuts, out);
  make_cell_fragments(model, cuts, edges, earlier, out);
  out.stages.tissue = out.label;
  TURGOR_CHECK(is_sorted_unique(out.cells, &CutCell::slot), "cut cells ascend by slot");
  TURGOR_CHECK(std::is_sorted(edges.pairs.begin(), edges.pairs.end()), "cut edges ascend by cell");
  // virtual nodes of the connected fragments
  make_virtual_nodes(model, earlier, out);
  merge_small_components(cuts, earlier, out);
  fit_virtual_nodes(model, cuts, edges, earlier, out);
  mark_excised(cuts, out);
  // labels of air, and ghosts
  for (const CutCell& cell : out.cells)
    if (const int index = earlier.index(out, cell); index >= 0)
      copy_air_labels(*earlier.fragments, index, cell, out);
    else
      label_air(CellSubLattice(out, cell));
  for (CutCell& cell : out.cells)
    if (cell.is_cut && cell.fragment_count > 0) find_ghosts(out, cell);
  TURGOR_CHECK(std::all_of(out.cells.begin(), out.cells.end(),
                           [&](const CutCell& c) {
                             return std::size_t(c.first_fragment + c.fragment_count) <= out.all.size() &&
                                    std::size_t(c.first_tip + c.tip_count) <= out.tips.size() &&
                                    std::size_t(c.first_ghost + c.ghost_count) <= out.ghosts.size();
                           }),
               "the fragments, crack tips and ghosts of a cell are listed");
  return out;
}

std::shared_ptr<const Fragments> fragments_of(const Model& model, const Cuts& cuts) {
  if (cuts.fragments && cuts.fragments->version == cut_version(cuts)) return cuts.fragments;
  return std::make_shared<const Fragments>(make_fragments(model, cuts));
}

void store_fragments(const Model& model, Cuts& cuts) {
  cuts.fragments = std::make_shared<const Fragments>(make_fragments(model, cuts, cuts.fragments.get()));
}

}  // namespace turgor::lattice

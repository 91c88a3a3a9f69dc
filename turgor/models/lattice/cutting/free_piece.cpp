// Tissue that a blade cut free, its mass, and its excision.
#include <algorithm>
#include <cmath>
#include <set>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/cut_topology.hpp"
#include "turgor/models/lattice/cutting/excision.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"

namespace turgor::lattice {

namespace {

constexpr int kWholeCell = -1;
using CellTissueId = std::pair<int, int>;  // slot of the cell's lowest node, fragment

/// Search over tissue that is connected through common nodes of the fine lattice.
struct PieceSearch {
  const Model& model;
  const Cuts& cuts;
  const Fragments& fragments;
  Int3 low, high;  // cells that a piece may reach
  std::set<CellTissueId> found;
  std::vector<CellTissueId> open;
  bool has_left = false;

  int label(const CutCell& cell, Int3 fine_node) const {
    const Int3 local = fine_node - first_of_cell(fragments.fine, slot_node(fragments.fine.cells, cell.slot));
    return fragments.label[cell.first_sub_index + std::size_t(sub_index(fragments.fine, local))];
  }
  bool has_tissue(Int3 cell) const {
    for (int c = 0; c < kCellCorners; c++)
      if (was_solid(model, cuts, node_slot(model.anatomy.lattice, cell + cell_corner(c)))) return true;
    return false;
  }
  /// Adds the tissue of a cell that contains a fine node.
  void add(Int3 cell, Int3 fine_node) {
    const int slot = node_slot(model.anatomy.lattice, cell);
    int fragment = kWholeCell;
    if (const CutCell* cut = find_cell(fragments, slot)) {
      fragment = label(*cut, fine_node);
      if (fragment < 0 || fragment >= cut->fragment_count) return;
    } else if (!has_tissue(cell)) {
      return;
    }
    if (!found.insert({slot, fragment}).second) return;
    open.push_back({slot, fragment});
    for (int axis = 0; axis < 3; axis++) has_left |= cell[axis] < low[axis] || cell[axis] > high[axis];
  }
  /// Adds everything that is connected.
  void spread() {
    const FineLattice& f = fragments.fine;
    while (!open.empty() && !has_left) {
      const auto [slot, fragment] = open.back();
      open.pop_back();
      const Int3 cell = slot_node(f.cells, slot), first = first_of_cell(f, cell);
      const CutCell* cut = fragment == kWholeCell ? nullptr : find_cell(fragments, slot);
      for_sub_nodes(f, [&, fragment = fragment](Int3 p) {
        bool border = false;
        for (int axis = 0; axis < 3; axis++) border |= p[axis] == 0 || p[axis] == f.subdivisions[axis];
        if (!border || (cut && label(*cut, first + p) != fragment)) return;
        for_cells_of_edge(f, first + p, first + p, [&](Int3 other) {
          if (!(other == cell)) add(other, first + p);
        });
      });
    }
  }
};

/// Cells around the edges that an incision cut, and the center of these edges [cells].
struct CutRegion {
  Int3 low, high;
  Vec3d center;
  int edges = 0;
};
CutRegion region_of(const Cuts& cuts, const FineLattice& f, int incision) {
  constexpr int kMargin = 2;
  CutRegion region;
  for (const CutEdge& edge : cuts.edges) {
    if (edge.incision != incision) continue;
    const Int3 cell = slot_node(f.cells, edge.slot);
    region.low = region.edges == 0 ? cell : min(region.low, cell);
    region.high = region.edges == 0 ? cell : max(region.high, cell);
    region.center += lattice_index(f, fine_node(f, edge)), region.edges++;
  }
  const Int3 margin{kMargin, kMargin, kMargin};
  region.low -= margin, region.high += margin;
  if (region.edges > 0) region.center = region.center / double(region.edges);
  return region;
}

/// True if a node was tissue or rim before excisions.
bool was_body(const Model& model, const Cuts& cuts, int slot) {
  return was_solid(model, cuts, slot) || (is_rim(model, slot) && cuts.removed[std::size_t(slot)] != kRemoved);
}

/// Lists nodes and sub-lattice nodes of the tissue of a piece.
void list_nodes(const Model& model, const Cuts& cuts, const Fragments& fragments, FreePiece& piece) {
  const FineLattice& f = fragments.fine;
  for (const auto& [slot, fragment] : piece.tissue) {
    const CutCell* cut = fragment == kWholeCell ? nullptr : find_cell(fragments, slot);
    const Int3 cell = slot_node(f.cells, slot);
    const auto has = [&, fragment = fragment](Int3 local) {
      return cut == nullptr ||
             fragments.label[cut->first_sub_index + std::size_t(sub_index(f, local))] == fragment;
    };
    for (int c = 0; c < kCellCorners; c++) {
      const int node = node_slot(f.cells, cell + cell_corner(c));
      if (has(hadamard(cell_corner(c), f.subdivisions)) && was_body(model, cuts, node))
        piece.nodes.push_back(node);
    }
    if (cut)
      for_sub_nodes(f, [&, s = slot](Int3 p) {
        if (has(p)) piece.sub_nodes.push_back(excised_key(s, sub_index(f, p)));
      });
  }
  sort_unique(piece.nodes), sort_unique(piece.sub_nodes);
}

/// Share of a tetrahedron that is in the tissue, from the corners that are. `t(p, q)`: fraction of the edge
/// from p, inside, to q, outside, that is in. Exact for a plane. Two corners leave a wedge of three
/// tetrahedra.
template <class Fraction>
double share_of_tetrahedron(const std::array<bool, 4>& inside, const Fraction& t) {
  std::array<std::size_t, 4> in{}, out{};
  std::size_t in_count = 0, out_count = 0;
  for (std::size_t c = 0; c < 4; c++) (inside[c] ? in[in_count++] : out[out_count++]) = c;
  if (in_count == 0 || out_count == 0) return in_count == 0 ? 0 : 1;
  if (in_count == 1) return t(in[0], out[0]) * t(in[0], out[1]) * t(in[0], out[2]);
  if (in_count == 3) return 1 - (1 - t(in[0], out[0])) * (1 - t(in[1], out[0])) * (1 - t(in[2], out[0]));
  const double ac = t(in[0], out[0]), ad = t(in[0], out[1]), bc = t(in[1], out[0]), bd = t(in[1], out[1]);
  return ac * ad + ad * bc * (1 - ac) + bc * bd * (1 - ad);
}

/// Fraction of a cell that belongs to one of its fragments, or to its tissue: the volume of its part of the
/// tetrahedra of the fine lattice, whose edges end where they are cut or leave the tissue.
double fraction_of(const Model& model, const Cuts& cuts, const Fragments& fragments, CellTissueId id) {
  const FineLattice& f = fragments.fine;
  const CutCell* cut = id.second == kWholeCell ? nullptr : find_cell(fragments, id.first);
  const Int3 cell = slot_node(f.cells, id.first), first = first_of_cell(f, cell);
  std::array<double, 8> level;
  for (int c = 0; c < kCellCorners; c++)
    level[std::size_t(c)] = double(node_level(model, cuts, node_slot(f.cells, cell + cell_corner(c))));
  const auto level_at = [&](Int3 p) {
    const auto weight = trilinear(Vec3d{double(p.x) / f.subdivisions.x, double(p.y) / f.subdivisions.y,
                                        double(p.z) / f.subdivisions.z});
    double sum = 0;
    for (std::size_t c = 0; c < 8; c++) sum += weight[c] * level[c];
    return sum;
  };
  const auto has = [&](Int3 p) {
    return cut == nullptr ||
           fragments.label[cut->first_sub_index + std::size_t(sub_index(f, p))] == id.second;
  };
  // share of the edge from p, in the fragment and the tissue, to q, which is not
  const auto share_of_edge = [&](Int3 p, Int3 q) {
    const double a = level_at(p), b = level_at(q), skin = b > 0 ? 1 : a / (a - b);
    if (has(q)) return skin;
    const Crossing found = crossing(fragments, cuts, first + p, first + q);
    return found.edge ? std::min(double(found.fraction), skin) : b > 0 ? 0.5 : skin;
  };
  // the six tetrahedra around the diagonal of each fine cell
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  double sum = 0;
  for_sub_nodes(f, [&](Int3 low) {
    if (!in_cell(f, low + Int3{1, 1, 1})) return;
    for (const auto& order : kOrders) {
      std::array<Int3, 4> corner{low, low, low, low};
      for (std::size_t c = 1; c < 4; c++) corner[c] = corner[c - 1], corner[c][order[c - 1]]++;
      std::array<bool, 4> inside{};
      for (std::size_t c = 0; c < 4; c++) inside[c] = has(corner[c]) && level_at(corner[c]) > 0;
      sum += share_of_tetrahedron(
          inside, [&](std::size_t p, std::size_t q) { return share_of_edge(corner[p], corner[q]); });
    }
  });
  return sum / (6.0 * f.subdivisions.x * f.subdivisions.y * f.subdivisions.z);
}

}  // namespace

Result<FreePiece> find_piece(const Model& model, const Cuts& cuts, int incision) {
  const std::shared_ptr<const Fragments> fragments = fragments_of(model, cuts);
  const FineLattice& f = fragments->fine;
  const CutRegion region = region_of(cuts, f, incision);
  if (region.edges == 0) return Error{"the blade met no tissue: expected a piece of skin"};
  // tissue in the middle of the cut
  PieceSearch search{model, cuts, *fragments, region.low, region.high, {}, {}};
  Int3 seed;
  for (int axis = 0; axis < 3; axis++)
    seed[axis] = int(std::lround(region.center[axis] * f.subdivisions[axis]));
  for_cells_of_edge(f, seed, seed, [&](Int3 cell) {
    if (search.found.empty()) search.add(cell, seed);
  });
  if (search.found.empty())
    return Error{"no tissue lies in the middle of the piece: expected a piece of skin"};
  search.spread();
  if (search.has_left)
    return Error{
        "the piece is still connected to the body: expected a piece of at least two lattice spacings "
        "in width and depth"};
  // its nodes
  FreePiece piece;
  piece.tissue.assign(search.found.begin(), search.found.end());
  list_nodes(model, cuts, *fragments, piece);
  if (piece.nodes.empty())
    return Error{"the piece contains no node of the lattice: expected a larger piece or a smaller spacing"};
  for (const int node : piece.nodes)
    if (model.anatomy.inverse_mass[std::size_t(node)] == 0)
      return Error{"the piece contains fixed tissue: expected one above bone and between the fixed ends"};
  return piece;
}

FreePiece rest_of_body(const Model& model, const Cuts& cuts, const FreePiece& piece) {
  const std::shared_ptr<const Fragments> fragments = fragments_of(model, cuts);
  FreePiece rest;
  for (int slot = 0; slot < slot_count(model.anatomy.lattice); slot++)
    if (was_body(model, cuts, slot) && !std::binary_search(piece.nodes.begin(), piece.nodes.end(), slot))
      rest.nodes.push_back(slot);
  for (const CutCell& cell : fragments->cells)
    for (int p = 0; p < sub_node_count(fragments->fine); p++)
      if (const std::uint64_t key = excised_key(cell.slot, p);
          !std::binary_search(piece.sub_nodes.begin(), piece.sub_nodes.end(), key))
        rest.sub_nodes.push_back(key);
  TURGOR_CHECK(std::is_sorted(rest.sub_nodes.begin(), rest.sub_nodes.end()), "keys of sub-nodes ascend");
  return rest;
}

PieceMass mass_of(const Model& model, const Cuts& cuts, const FreePiece& piece) {
  const std::shared_ptr<const Fragments> fragments = fragments_of(model, cuts);
  const Vec3d h(model.anatomy.lattice.spacing);
  PieceMass sum;
  for (const CellTissueId& id : piece.tissue) {
    const double fraction = fraction_of(model, cuts, *fragments, id);
    // mean mass of the tissue nodes around; a node has the mass of a cell
    double mass = 0;
    int count = 0;
    for (int c = 0; c < kCellCorners; c++) {
      const auto node = std::size_t(
          node_slot(model.anatomy.lattice, slot_node(model.anatomy.lattice, id.first) + cell_corner(c)));
      if (is_body(model.anatomy.tissue[node]) && model.anatomy.inverse_mass[node] > 0)
        mass += 1 / double(model.anatomy.inverse_mass[node]), count++;
    }
    sum.volume += fraction * h.x * h.y * h.z;
    if (count > 0) sum.mass += fraction * mass / count;
  }
  return sum;
}

void mark_excised(const FreePiece& piece, Cuts& cuts) {
  for (const int node : piece.nodes)
    if (cuts.removed[std::size_t(node)] == 0)
      cuts.removed[std::size_t(node)] = kExcised, cuts.removed_nodes++;
  cuts.excised.insert(cuts.excised.end(), piece.sub_nodes.begin(), piece.sub_nodes.end());
  sort_unique(cuts.excised);
}

void excise(const Model& model, State& state, const FreePiece& piece) {
  mark_excised(piece, state.cuts);
  state.sleep.still_steps.clear();  // wakes all rows
  for (const int node : piece.nodes) state.motion.v.set(std::size_t(node), {});
  build_cut_elements(model, state);
}

}  // namespace turgor::lattice

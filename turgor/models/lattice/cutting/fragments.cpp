#include "turgor/models/lattice/cutting/fragments.hpp"

#include <algorithm>
#include <limits>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/crack_tips.hpp"
#include "turgor/models/lattice/cutting/small_components.hpp"
#include "turgor/models/lattice/cutting/virtual_node_fit.hpp"
#include "turgor/models/lattice/cutting/virtual_nodes.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// The slots of the cells that have a cut edge, and of those around their nodes.
void find_cells(const State& state, Fragments& out) {
  const Lattice& l = out.fine.cells;
  std::vector<int> cut, near;
  for (const CutEdge& edge : state.cut_edges) {
    const Int3 a = fine_node(out.fine, edge);
    for_cells_of_edge(out.fine, a, a + kFamilies[edge.family],
                      [&](Int3 cell) { cut.push_back(node_slot(l, cell)); });
  }
  sort_unique(cut);
  for (const int slot : cut) {
    const Int3 cell = slot_node(l, slot);
    const Int3 low = max(cell - Int3{1, 1, 1}, Int3{0, 0, 0}),
               high = min(cell + Int3{1, 1, 1}, l.size - Int3{2, 2, 2});
    for (int k = low.z; k <= high.z; k++)
      for (int j = low.y; j <= high.y; j++)
        for (int i = low.x; i <= high.x; i++) near.push_back(node_slot(l, i, j, k));
  }
  sort_unique(near);
  const auto places = std::size_t(places_of_cell(out.fine));
  for (const int slot : near) {
    out.cell_index.find_or_add(std::uint64_t(slot));
    out.cells.push_back({.slot = slot,
                         .places = out.cells.size() * places,
                         .is_cut = std::binary_search(cut.begin(), cut.end(), slot)});
  }
  out.label.assign(out.cells.size() * places, -1);
  out.cut.assign(out.cells.size() * places, 0);
}

/// Which edges of which cell are cut, by place.
EdgesOfCells note_cuts(const State& state, Fragments& out) {
  const FineLattice& f = out.fine;
  EdgesOfCells edges;
  for (std::size_t n = 0; n < state.cut_edges.size(); n++) {
    const CutEdge& edge = state.cut_edges[n];
    const Int3 a = fine_node(f, edge);
    out.edge_index.find_or_add(fine_edge_key(f, a, edge.family));
    for_cells_of_edge(f, a, a + kFamilies[edge.family], [&](Int3 cell) {
      const CutCell& c = *find_cell(out, node_slot(f.cells, cell));
      const int place = place_in_cell(f, a - first_of_cell(f, cell));
      out.cut[c.places + std::size_t(place)] |= std::uint8_t(1u << edge.family);
      edges.pairs.emplace_back(int(&c - out.cells.data()), int(n));
    });
  }
  std::sort(edges.pairs.begin(), edges.pairs.end());
  return edges;
}

/// The places of one cell and the ways between them.
struct CellPlaces {
  const FineLattice& fine;
  const std::uint8_t* cut;
  std::int16_t* label;
  int offset[kFamilyCount];

  CellPlaces(Fragments& pieces, const CutCell& cell)
      : fine(pieces.fine), cut(&pieces.cut[cell.places]), label(&pieces.label[cell.places]) {
    for (int n = 0; n < kFamilyCount; n++) offset[n] = place_in_cell(fine, kFamilies[std::size_t(n)]);
  }
  /// Calls visit(neighbour, its place) for all neighbours in the cell along uncut edges.
  template <class Visit>
  void for_joined(Int3 local, const Visit& visit) const {
    const int place = place_in_cell(fine, local);
    for (int n = 0; n < kFamilyCount; n++) {
      const Int3 up = local + kFamilies[std::size_t(n)], down = local - kFamilies[std::size_t(n)];
      if (in_cell(fine, up) && !(cut[place] >> n & 1)) visit(up, place + offset[n]);
      if (in_cell(fine, down) && !(cut[place - offset[n]] >> n & 1)) visit(down, place - offset[n]);
    }
  }
};

/// Fine nodes that are tissue, by the trilinear level of a cell's corners.
std::array<bool, kMostPlaces> solid_places(const Model& model, const State& state, const FineLattice& f,
                                           int slot) {
  std::array<Real, 8> level;
  const int parity = slot_node(f.cells, slot).x & 1;
  for (int c = 0; c < 8; c++)
    level[std::size_t(c)] = node_level(model, state, slot + slot_offset(f.cells, cell_corner(c), parity));
  std::array<bool, kMostPlaces> solid{};
  for_places(f, [&](Int3 p) {
    const auto weight = trilinear(
        Vec3{Real(p.x) / Real(f.parts.x), Real(p.y) / Real(f.parts.y), Real(p.z) / Real(f.parts.z)});
    Real sum = 0;
    for (std::size_t c = 0; c < 8; c++) sum += weight[c] * level[c];
    solid[std::size_t(place_in_cell(f, p))] = sum > 0;
  });
  return solid;
}

/// Numbers the pieces of a cell by flood fill over its tissue; what is air stays -1.
int label_tissue(const CellPlaces& places, const std::array<bool, kMostPlaces>& solid) {
  int count = 0;
  std::vector<Int3> open;
  for_places(places.fine, [&](Int3 start) {
    const int at = place_in_cell(places.fine, start);
    if (!solid[std::size_t(at)] || places.label[at] >= 0) return;
    places.label[at] = std::int16_t(count);
    open.assign(1, start);
    while (!open.empty()) {
      const Int3 p = open.back();
      open.pop_back();
      places.for_joined(p, [&](Int3 next, int place) {
        if (!solid[std::size_t(place)] || places.label[place] >= 0) return;
        places.label[place] = std::int16_t(count);
        open.push_back(next);
      });
    }
    count++;
  });
  return count;
}

/// Air takes the label of the tissue that it is nearest to on its own side of the blades; what has none there
/// stays -1.
void label_air(const CellPlaces& places) {
  std::vector<Int3> open;
  for_places(places.fine, [&](Int3 p) {
    if (places.label[place_in_cell(places.fine, p)] >= 0) open.push_back(p);
  });
  for (std::size_t next = 0; next < open.size(); next++) {
    const Int3 p = open[next];
    const std::int16_t label = places.label[place_in_cell(places.fine, p)];
    places.for_joined(p, [&](Int3 beside, int place) {
      if (places.label[place] >= 0) return;
      places.label[place] = label;
      open.push_back(beside);
    });
  }
}

/// Finds the guests of a cell: at places without a piece that lie in other cells, too, then at what is joined
/// to these.
void find_ghosts(Fragments& out, CutCell& cell) {
  const FineLattice& f = out.fine;
  const CellPlaces places(out, cell);
  const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
  cell.first_ghost = int(out.ghosts.size());
  std::vector<std::pair<Int3, std::int16_t>> found;
  for_places(f, [&](Int3 p) {
    if (places.label[place_in_cell(f, p)] != -1) return;
    GhostFragment ghost{.slot = cell.slot, .cell = -1};
    for_cells_of_edge(f, first + p, first + p, [&](Int3 beside) {
      const int other = out.cell_index.find(std::uint64_t(node_slot(f.cells, beside)));
      if (other < 0 || ghost.cell >= 0) return;
      const std::size_t place = out.cells[std::size_t(other)].places +
                                std::size_t(place_in_cell(f, first + p - first_of_cell(f, beside)));
      if (out.label[place] >= 0) ghost.cell = other, ghost.piece = out.label[place];
    });
    if (ghost.cell < 0) return;
    const auto known =
        std::find_if(out.ghosts.begin() + cell.first_ghost, out.ghosts.end(),
                     [&](GhostFragment g) { return g.cell == ghost.cell && g.piece == ghost.piece; });
    found.emplace_back(p, std::int16_t(-2 - (known - out.ghosts.begin() - cell.first_ghost)));
    if (known == out.ghosts.end()) out.ghosts.push_back(ghost);
  });
  for (const auto& [p, label] : found) places.label[place_in_cell(f, p)] = label;
  for (std::size_t next = 0; next < found.size(); next++) {
    const std::int16_t label = found[next].second;
    places.for_joined(Int3(found[next].first), [&](Int3 beside, int place) {
      if (places.label[place] != -1) return;
      places.label[place] = label;
      found.emplace_back(beside, label);
    });
  }
  cell.ghost_count = int(out.ghosts.size()) - cell.first_ghost;
}

/// Which blade entered a piece of a cell without parting it: that of most edges that are cut between places
/// of the piece; where such are between corners of the cell; -1: none.
int blade_in(const State& state, const Fragments& pieces, const EdgesOfCells& edges, const CutCell& cell,
             const CellPlaces& places, int piece) {
  const FineLattice& f = pieces.fine;
  const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
  const auto has = [&](Int3 local) { return places.label[place_in_cell(f, local)] == piece; };
  bool between_corners = false;
  const int parity = slot_node(f.cells, cell.slot).x & 1;
  for (int c = 0; c < 8; c++)
    for (int n = 0; n < kFamilyCount; n++) {
      if (!(edges_from_corner(c) >> n & 1)) continue;
      const Int3 low = cell_corner(c), high = low + kFamilies[std::size_t(n)];
      if (!has(hadamard(low, f.parts)) || !has(hadamard(high, f.parts))) continue;
      between_corners |=
          (state.cut[std::size_t(cell.slot + slot_offset(f.cells, low, parity))] >> n & 1) != 0;
    }
  if (!between_corners) return -1;
  std::array<int, 256> count{};
  const int index = int(&cell - pieces.cells.data());
  auto at = std::lower_bound(edges.pairs.begin(), edges.pairs.end(), std::pair(index, -1));
  for (; at != edges.pairs.end() && at->first == index; ++at) {
    const CutEdge& edge = state.cut_edges[std::size_t(at->second)];
    const Int3 a = fine_node(f, edge) - first;
    if (has(a) && has(a + kFamilies[edge.family])) count[edge.incision]++;
  }
  const auto most = std::max_element(count.begin(), count.end());
  return *most > 0 ? int(most - count.begin()) : -1;
}

/// Parts a piece of a cell that a blade entered: by a plane.
void part_tip(const State& state, Fragments& pieces, const EdgesOfCells& edges, CutCell& cell,
              const CellPlaces& places, int piece) {
  const int incision = blade_in(state, pieces, edges, cell, places, piece);
  if (incision < 0) return;
  const std::optional<CrackTipPlane> plane = fit_tip(state, pieces, edges, cell, incision);
  if (!plane) return;
  const Int3 first = first_of_cell(pieces.fine, slot_node(pieces.fine.cells, cell.slot));
  const auto is_right = [&](Int3 p) { return plane->at(lattice_index(pieces.fine, first + p)) >= 0; };
  const auto label = [&](Int3 p) -> std::int16_t& { return places.label[place_in_cell(pieces.fine, p)]; };
  bool any[2] = {false, false};
  for_places(pieces.fine, [&](Int3 p) {
    if (label(p) == piece) any[is_right(p)] = true;
  });
  if (!any[0] || !any[1]) return;
  for_places(pieces.fine, [&](Int3 p) {
    if (label(p) == piece && is_right(p)) label(p) = std::int16_t(cell.fragment_count);
  });
  pieces.tips.push_back({*plane, piece, cell.fragment_count++, std::uint8_t(incision)});
}

/// The fine node of a piece with the lowest index.
std::uint64_t first_place(const Fragments& pieces, const CutCell& cell, int piece) {
  const Int3 first = first_of_cell(pieces.fine, slot_node(pieces.fine.cells, cell.slot));
  std::uint64_t lowest = std::numeric_limits<std::uint64_t>::max();
  for_places(pieces.fine, [&](Int3 p) {
    if (pieces.label[cell.places + std::size_t(place_in_cell(pieces.fine, p))] == piece)
      lowest = std::min(lowest, fine_index(pieces.fine, first + p));
  });
  return lowest;
}

/// Has a piece of a cell no area in any of the cell's faces: no three fine nodes of a square?
bool is_thin(const Fragments& pieces, const CutCell& cell, int piece) {
  const FineLattice& f = pieces.fine;
  bool found = false;
  const auto has = [&](Int3 p) {
    return pieces.label[cell.places + std::size_t(place_in_cell(f, p))] == piece;
  };
  for (int axis = 0; axis < 3; axis++) {
    const Int3 u = kFamilies[std::size_t((axis + 1) % 3)], v = kFamilies[std::size_t((axis + 2) % 3)];
    for_places(f, [&](Int3 p) {
      if ((p[axis] != 0 && p[axis] != f.parts[axis]) || !in_cell(f, p + u + v)) return;
      found = found || has(p) + has(p + u) + has(p + v) + has(p + u + v) >= 3;
    });
  }
  return !found;
}

void make_cell_pieces(const Model& model, const State& state, const EdgesOfCells& edges, Fragments& out) {
  for (std::size_t c = 0; c < out.cells.size(); c++) {
    CutCell& cell = out.cells[c];
    const CellPlaces places(out, cell);
    cell.first_fragment = int(out.pieces.size());
    cell.fragment_count = label_tissue(places, solid_places(model, state, out.fine, cell.slot));
    cell.first_tip = int(out.tips.size());
    const int found = cell.is_cut ? cell.fragment_count : 0;
    for (int piece = 0; piece < found; piece++) part_tip(state, out, edges, cell, places, piece);
    cell.tip_count = int(out.tips.size()) - cell.first_tip;
    for (int p = 0; p < cell.fragment_count; p++) {
      const int parity = slot_node(out.fine.cells, cell.slot).x & 1;
      Fragment piece{
          .cell = int(c), .place = first_place(out, cell, p), .thin = is_thin(out, cell, p), .corner = {}};
      for (int n = 0; n < 8; n++)
        piece.corner[std::size_t(n)] = cell.slot + slot_offset(out.fine.cells, cell_corner(n), parity);
      out.pieces.push_back(piece);
    }
  }
}

}  // namespace

Real node_level(const Model& model, const State& state, int slot) {
  constexpr Real kLeast = 4, kGas = 500;  // [HU]
  const auto s = std::size_t(slot);
  const Real beyond = Real(model.hu[s]) - Real(model.params.tissue.air_max);
  if (state.removed[s]) return -kGas;
  if (!is_body(model.tissue[s])) return std::min(beyond, -kLeast);
  return beyond < 0 ? kGas : std::max(beyond, kLeast);
}

Fragments make_fragments(const Model& model, const State& state) {
  Fragments out;
  out.fine = fine_lattice(model);
  out.version = cut_version(state);
  if (state.cut_edges.empty()) return out;
  find_cells(state, out);
  const EdgesOfCells edges = note_cuts(state, out);
  make_cell_pieces(model, state, edges, out);
  make_copies(out);
  merge_small_components(state, out);
  find_sources(model, state, edges, out);
  for (const CutCell& cell : out.cells) label_air(CellPlaces(out, cell));
  for (CutCell& cell : out.cells)
    if (cell.is_cut && cell.fragment_count > 0) find_ghosts(out, cell);
  return out;
}

}  // namespace turgor::lattice

#include "turgor/models/lattice/mechanics/cut_elements.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/crack_tips.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/resample/raster.hpp"

namespace turgor::lattice {

namespace {

bool has_parts(const Model& model) {
  return model.params.tissue.law == TissueLaw::kSolid && model.params.solver.method == Method::kVbd;
}

/// Was this cell whole, and is no longer?
bool is_parted(const Model& model, const State& state, const Fragments& pieces, const CutCell& cell) {
  if (!(model.cell_young[std::size_t(cell.slot)] > 0)) return false;
  bool other = cell.fragment_count > 1 || has_cut_edge(state, model.lattice, cell.slot), removed = false;
  const int parity = slot_node(model.lattice, cell.slot).x & 1;
  for (int n = 0; n < kCellCorners; n++) {
    const int slot = cell.slot + slot_offset(model.lattice, cell_corner(n), parity);
    removed |= state.removed[std::size_t(slot)] != 0;
    for (int p = cell.first_fragment; p < cell.first_fragment + cell.fragment_count; p++)
      other |= pieces.pieces[std::size_t(p)].corner[std::size_t(n)] != slot;
  }
  return other && !removed;
}

/// Do all corners of a piece lead to nodes of tissue? Else it is a crumb that hangs on nothing.
bool hangs_on_nodes(const Model& model, const State& state, const Fragments& pieces, const Fragment& piece) {
  const int slots = slot_count(model.lattice);
  return std::all_of(piece.corner.begin(), piece.corner.end(), [&](int corner) {
    if (corner < slots) return is_solid(model, state, corner);
    const VirtualNode& copy = pieces.virtual_nodes[std::size_t(corner - slots)];
    return is_solid(model, state, copy.slot) && copy.source_count > 0;
  });
}

/// Calls visit(cell, piece) for all pieces that bear something.
template <class Visit>
void for_bearing(const Model& model, const State& state, const Fragments& pieces, const Visit& visit) {
  for (const CutCell& cell : pieces.cells) {
    if (!is_parted(model, state, pieces, cell)) continue;
    for (int p = 0; p < cell.fragment_count; p++)
      if (hangs_on_nodes(model, state, pieces, pieces.pieces[std::size_t(cell.first_fragment + p)]))
        visit(cell, p);
  }
}

/// Lengths within a cell's pieces along one axis, and how often a line goes from one to another.
struct Lengths {
  std::vector<double> of;
  double crossings = 0;
};
Lengths lengths_along(const Fragments& pieces, const State& state, const CutCell& cell, int axis) {
  const FineLattice& f = pieces.fine;
  const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot)), way = kFamilies[std::size_t(axis)];
  Lengths found{.of = std::vector<double>(std::size_t(cell.fragment_count))};
  const auto label = [&](Int3 p) { return pieces.label[cell.places + std::size_t(place_in_cell(f, p))]; };
  for_places(f, [&](Int3 p) {
    if (!in_cell(f, p + way)) return;
    double weight = 1;
    for (int side = 0; side < 3; side++)
      if (side != axis && (p[side] == 0 || p[side] == f.parts[side])) weight *= 0.5;
    const int a = label(p), b = label(p + way);
    double fraction = 0.5;
    if (a != b) {
      found.crossings += weight;
      if (const Crossing cut = crossing(pieces, state, first + p, first + p + way); cut.edge)
        fraction = double(cut.fraction);
    }
    if (a >= 0) found.of[std::size_t(a)] += weight * fraction;
    if (b >= 0) found.of[std::size_t(b)] += weight * (1 - fraction);
  });
  return found;
}

/// Where a blade ends in a cell, what it did not reach stays whole: so much of it, by the share of its
/// section that the blade went through. Less than what is left of the section, as tissue beside a blade's end
/// is bent and stretched most at the very end; with these numbers gapes are nearest to those of elements
/// (docs/models/lattice.md).
double bridge(double cut_samples) {
  const double left = (1 - cut_samples) * (1 - cut_samples);
  return left * left / (1 + 10 * cut_samples);
}

/// How a cell's tissue is parted, measured along the axis that crosses the blades most.
struct Shares {
  std::vector<Real> of;       // of each piece, in the cell
  std::vector<Real> parted;   // of each piece: what is not bridged
  std::vector<Real> bridges;  // of each tip, in both its pieces
};
Shares shares_of(const Fragments& pieces, const State& state, const CutCell& cell) {
  Lengths best = lengths_along(pieces, state, cell, 0);
  for (int axis = 1; axis < 3; axis++)
    if (Lengths found = lengths_along(pieces, state, cell, axis); found.crossings > best.crossings)
      best = std::move(found);
  constexpr double kLeast = 1e-3;
  double sum = 0;
  for (double& length : best.of) length = std::max(length, kLeast), sum += length;
  Shares shares;
  for (const double length : best.of) shares.of.push_back(Real(length / sum));
  shares.parted.assign(best.of.size(), 1);
  for (int t = cell.first_tip; t < cell.first_tip + cell.tip_count; t++) {
    const CrackTip& tip = pieces.tips[std::size_t(t)];
    const double cut_samples = cut_fraction(state, pieces, cell, tip);
    shares.bridges.push_back(Real(std::min(1 - kLeast, bridge(cut_samples))));
    for (const int piece : {tip.left, tip.right})
      shares.parted[std::size_t(piece)] = 1 - shares.bridges.back();
  }
  return shares;
}
/// Of the cells that are asked for, once each.
struct KnownShares {
  const Fragments& pieces;
  const State& state;
  std::vector<std::optional<Shares>> known;

  KnownShares(const Fragments& p, const State& s) : pieces(p), state(s), known(p.cells.size()) {}
  const Shares& operator()(const CutCell& cell) {
    std::optional<Shares>& found = known[std::size_t(&cell - pieces.cells.data())];
    if (!found) found = shares_of(pieces, state, cell);
    return *found;
  }
};

/// What a bridge holds: of each corner of the cell the one on the side of the plane that it lies on. Where
/// one of its pieces hangs on nothing, the nodes.
std::array<int, 8> corners_of_bridge(const Model& model, const State& state, const Fragments& pieces,
                                     const CutCell& cell, const CrackTip& tip) {
  const auto piece_of = [&](int n) -> const Fragment& {
    return pieces.pieces[std::size_t(cell.first_fragment + n)];
  };
  if (!hangs_on_nodes(model, state, pieces, piece_of(tip.left)) ||
      !hangs_on_nodes(model, state, pieces, piece_of(tip.right)))
    return corners_of(model, pieces, cell.slot, -1);
  const Vec3d low(in_body(pieces.fine.cells, slot_node(pieces.fine.cells, cell.slot)));
  std::array<int, 8> corners;
  for (int n = 0; n < kCellCorners; n++)
    corners[std::size_t(n)] = piece_of(tip.plane.at(low + Vec3d(cell_corner(n))) >= 0 ? tip.right : tip.left)
                                  .corner[std::size_t(n)];
  return corners;
}

void add_cells(const Model& model, State& state, const Fragments& pieces, KnownShares& shares_in) {
  int last = -1;
  for_bearing(model, state, pieces, [&](const CutCell& cell, int piece) {
    const Real young = model.cell_young[std::size_t(cell.slot)];
    const Shares& shares = shares_in(cell);
    if (cell.slot != last) {
      last = cell.slot;
      state.cut[std::size_t(cell.slot)] |= kIsCut;
      mark_rows(model, state, cell.slot);
      for (int t = 0; t < cell.tip_count; t++) {
        const CrackTip& tip = pieces.tips[std::size_t(cell.first_tip + t)];
        const Real both = shares.of[std::size_t(tip.left)] + shares.of[std::size_t(tip.right)];
        state.parts.cells.push_back({corners_of_bridge(model, state, pieces, cell, tip),
                                     young * shares.bridges[std::size_t(t)] * both});
      }
    }
    const auto p = std::size_t(piece);
    state.parts.cells.push_back({pieces.pieces[std::size_t(cell.first_fragment + piece)].corner,
                                 young * shares.parted[p] * shares.of[p]});
  });
}

/// Share of a triangle in each piece of the cell that it lies in, by points.
std::vector<int> count_points(const Fragments& pieces, const State& state, const CutCell& cell,
                              const Vec3 (&corner)[3], int parts) {
  std::vector<int> count(std::size_t(cell.fragment_count));
  const auto add = [&](Real a, Real b) {
    const Vec3 at = corner[0] + (corner[1] - corner[0]) * a + (corner[2] - corner[0]) * b;
    const int piece = fragment_at(pieces, state, cell, at);
    if (piece >= 0) count[piece < cell.fragment_count ? std::size_t(piece) : 0]++;  // skin is the cell's
  };
  const Real part = Real(1) / Real(parts);
  for (int i = 0; i < parts; i++)
    for (int j = 0; i + j < parts; j++) {
      add((Real(i) + Real(1) / 3) * part, (Real(j) + Real(1) / 3) * part);
      if (i + j + 1 < parts) add((Real(i) + Real(2) / 3) * part, (Real(j) + Real(2) / 3) * part);
    }
  return count;
}

void part_triangle(const Model& model, State& state, const Fragments& pieces, KnownShares& shares_in, int t) {
  constexpr int kParts = 8;
  const Lattice& l = model.lattice;
  Int3 node[3], low = l.size - Int3{2, 2, 2};
  for (int c = 0; c < 3; c++) {
    node[c] = slot_node(l, model.skin.triangles[std::size_t(t)].vertex[c]);
    low = min(low, node[c]);
  }
  const CutCell* cell = find_cell(pieces, node_slot(l, low));
  if (cell == nullptr) return;
  const Vec3 places[3] = {Vec3(node[0] - low), Vec3(node[1] - low), Vec3(node[2] - low)};
  const std::vector<int> count = count_points(pieces, state, *cell, places, kParts);
  const Shares& shares = shares_in(*cell);
  const auto add = [&](const std::array<int, 8>& corners, Real share) {
    CutSkinElement part{.triangle = t, .corner = {}, .share = share};
    bool borne = part.share > 0;
    for (int c = 0; c < 3; c++) {
      const Int3 at = node[c] - low;
      part.corner[c] = corners[std::size_t(corner_of(at))];
      borne = borne && is_borne(model, state, pieces, part.corner[c]);
    }
    if (borne) state.parts.skin.push_back(part);
  };
  const auto share = [&](int piece) { return Real(count[std::size_t(piece)]) / (kParts * kParts); };
  for (int b = 0; b < cell->tip_count; b++) {
    const CrackTip& tip = pieces.tips[std::size_t(cell->first_tip + b)];
    add(corners_of_bridge(model, state, pieces, *cell, tip),
        shares.bridges[std::size_t(b)] * (share(tip.left) + share(tip.right)));
  }
  for (int p = 0; p < cell->fragment_count; p++)
    add(pieces.pieces[std::size_t(cell->first_fragment + p)].corner,
        shares.parted[std::size_t(p)] * share(p));
}

/// Copies of a node of skin take their share of its pull with them, by area.
void share_pull(const Model& model, CutElements& parts) {
  const Skin& skin = model.skin;
  const int slots = slot_count(model.lattice);
  for (ElementNode& copy : parts.virtual_nodes) {
    const auto at =
        std::size_t(std::lower_bound(skin.nodes.begin(), skin.nodes.end(), copy.slot) - skin.nodes.begin());
    if (at == skin.nodes.size() || skin.nodes[at] != copy.slot) continue;
    const auto row = std::size_t(copy.slot / model.lattice.half);
    const int first = skin.corner_begin[std::size_t(skin.row_begin[row])];
    double whole = 0, part = 0;
    for (int c = skin.corner_begin[at]; c < skin.corner_begin[at + 1]; c++)
      whole += double(skin.corners[std::size_t(skin.lanes_begin[row] + (c - first) / kSkinLanes)]
                          .area[(c - first) % kSkinLanes]);
    for (int u = copy.first; u < copy.first + copy.count; u++)
      if (const int s = -1 - parts.uses[std::size_t(u)].part; s >= 0)
        part += double(parts.skin[std::size_t(s)].share) *
                skin.triangles[std::size_t(parts.skin[std::size_t(s)].triangle)].area;
    copy.pull = skin.pull[at] * Real(part / whole);
    const auto node = std::lower_bound(parts.nodes.begin(), parts.nodes.end(), copy.slot,
                                       [](const ElementNode& n, int slot) { return n.slot < slot; });
    if (node != parts.nodes.end() && node->corner == copy.slot && copy.slot < slots) node->pull -= copy.pull;
  }
}

/// The nodes and copies that parts hang on, and what of each hangs there.
void add_nodes(const Model& model, const Fragments& pieces, CutElements& parts) {
  const int slots = slot_count(model.lattice);
  std::vector<std::pair<int, NodeElement>> uses;
  for (std::size_t p = 0; p < parts.cells.size(); p++)
    for (int n = 0; n < kCellCorners; n++)
      uses.push_back({parts.cells[p].corner[std::size_t(n)], {int(p), n}});
  for (std::size_t s = 0; s < parts.skin.size(); s++)
    for (int n = 0; n < 3; n++) uses.push_back({parts.skin[s].corner[n], {-1 - int(s), n}});
  std::stable_sort(uses.begin(), uses.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [corner, use] : uses) {
    auto& list = corner < slots ? parts.nodes : parts.virtual_nodes;
    if (list.empty() || list.back().corner != corner)
      list.push_back(
          {.corner = corner,
           .slot = corner < slots ? corner : pieces.virtual_nodes[std::size_t(corner - slots)].slot,
           .first = int(parts.uses.size())});
    list.back().count++;
    parts.uses.push_back(use);
  }
  for (int k = 0; k <= model.lattice.size.z; k++)
    parts.layer_begin.push_back(
        int(std::lower_bound(parts.virtual_nodes.begin(), parts.virtual_nodes.end(),
                             row_slot(model.lattice, -1, k),
                             [](const ElementNode& n, int slot) { return n.slot < slot; }) -
            parts.virtual_nodes.begin()));
}

/// Where the copies are: those that are known from before where they were.
void place_copies(const Model& model, State& state, const Fragments& pieces, const DownloadNodes& bring) {
  const std::vector<VirtualNodeShift> before = std::exchange(state.virtual_nodes, {});
  std::vector<VirtualNodeShift> now(pieces.virtual_nodes.size());
  const auto key = [](const VirtualNode& c) { return std::pair(c.slot, c.place); };
  const std::vector<std::pair<int, std::uint64_t>> known = std::exchange(state.parts.places, {});
  const auto corner = [&](std::size_t copy) { return slot_count(model.lattice) + int(copy); };
  std::vector<std::size_t> fresh;
  for (std::size_t c = 0; c < pieces.virtual_nodes.size(); c++) {
    const auto at = std::find(std::lower_bound(known.begin(), known.end(),
                                               std::pair(pieces.virtual_nodes[c].slot, std::uint64_t(0))),
                              known.end(), key(pieces.virtual_nodes[c]));
    state.parts.places.push_back(key(pieces.virtual_nodes[c]));
    if (at != known.end() && before.size() == known.size())
      now[c] = before[std::size_t(at - known.begin())];
    else
      fresh.push_back(c);
  }
  if (bring && !fresh.empty()) {
    std::vector<int> behind;
    for (const std::size_t c : fresh) add_nodes_behind(model, state, pieces, corner(c), behind);
    sort_unique(behind);
    bring(behind);
  }
  for (const std::size_t c : fresh) {
    const Vec3 u = corner_displacement(model, state, pieces, corner(c));
    now[c] = {u.x, u.y, u.z};
  }
  state.virtual_nodes = state.virtual_nodes_before = std::move(now);
}

}  // namespace

void mark_rows(const Model& model, State& state, int slot) {
  const int stride = row_stride(model.lattice), layer = layer_stride(model.lattice);
  for (int dk = -1; dk <= 1; dk++)
    for (int dj = -1; dj <= 1; dj++)
      state.row_cut[std::size_t((slot + dk * layer + dj * stride) / stride)] = 1;
}

void find_bearing(const Model& model, const State& state, Fragments& pieces) {
  if (!has_parts(model)) return;
  const int slots = slot_count(model.lattice);
  for_bearing(model, state, pieces, [&](const CutCell& cell, int piece) {
    for (const int corner : pieces.pieces[std::size_t(cell.first_fragment + piece)].corner)
      if (corner >= slots) pieces.virtual_nodes[std::size_t(corner - slots)].bears = true;
  });
}

void build_cut_elements(const Model& model, State& state, const DownloadNodes& bring) {
  if (!has_parts(model) || state.cut_edges.empty()) return;
  const Fragments pieces = make_fragments(model, state);
  place_copies(model, state, pieces, bring);
  CutElements& parts = state.parts;
  parts = {.places = std::move(parts.places)};
  KnownShares shares_in(pieces, state);
  add_cells(model, state, pieces, shares_in);
  for (std::size_t t = 0; t < state.skin_cut.size(); t++)
    if (state.skin_cut[t]) part_triangle(model, state, pieces, shares_in, int(t));
  add_nodes(model, pieces, parts);
  if (!model.skin.pull.empty()) share_pull(model, parts);
}

CutElementForces::CutElementForces(const Model& m, State& s)
    : nodes(node_arrays(m, s)),
      parts(s.parts),
      elements{nodes,
               slot_count(m.lattice),
               s.virtual_nodes.data(),
               s.parts.cells.data(),
               s.parts.skin.data(),
               s.parts.uses.data(),
               m.skin.triangles.data(),
               solid_law(m.lattice.step, m.params.tissue.poisson),
               SkinForces(m)} {}

namespace {
std::span<const ElementNode> between(const std::vector<ElementNode>& nodes, int slot, int count) {
  const auto before = [](const ElementNode& n, int s) { return n.slot < s; };
  const auto begin = std::lower_bound(nodes.begin(), nodes.end(), slot, before);
  return {begin, std::lower_bound(begin, nodes.end(), slot + count, before)};
}
}  // namespace

std::span<const ElementNode> CutElementForces::nodes_of(int slot, int count) const {
  return between(parts.nodes, slot, count);
}

std::span<const ElementNode> CutElementForces::virtual_nodes_of(int slot, int count) const {
  return between(parts.virtual_nodes, slot, count);
}

std::span<const ElementNode> CutElementForces::virtual_nodes_of(int k) const {
  if (parts.layer_begin.empty()) return {};
  const auto begin = std::size_t(parts.layer_begin[std::size_t(k)]),
             end = std::size_t(parts.layer_begin[std::size_t(k) + 1]);
  return std::span(parts.virtual_nodes).subspan(begin, end - begin);
}

}  // namespace turgor::lattice

#include "turgor/models/lattice/cutting/small_components.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

/// Which part each piece belongs to: pieces with a corner in common are of one.
std::vector<int> parts_of(const Fragments& pieces) {
  std::vector<int> part(pieces.pieces.size());
  std::iota(part.begin(), part.end(), 0);
  std::vector<std::pair<int, int>> of_corner;  // corner, piece
  for (int p = 0; p < int(part.size()); p++)
    for (const int corner : pieces.pieces[std::size_t(p)].corner) of_corner.emplace_back(corner, p);
  std::sort(of_corner.begin(), of_corner.end());
  for (std::size_t n = 1; n < of_corner.size(); n++)
    if (of_corner[n].first == of_corner[n - 1].first)
      join_sets(part, of_corner[n - 1].second, of_corner[n].second);
  for (int p = 0; p < int(part.size()); p++) part[std::size_t(p)] = root_of(part, p);
  return part;
}

/// One cell, by places.
struct CellLabels {
  const Fragments& pieces;
  const CutCell& cell;

  int at(Int3 p) const { return pieces.label[cell.places + std::size_t(place_in_cell(pieces.fine, p))]; }
  /// Fine cells that are all of one piece, by piece.
  void count_whole(std::vector<int>& whole) const {
    const std::uint8_t* cut = &pieces.cut[cell.places];
    for_places(pieces.fine, [&](Int3 p) {
      if (!in_cell(pieces.fine, p + Int3{1, 1, 1}) || at(p) < 0) return;
      for (int n = 0; n < 8; n++) {
        const Int3 q = p + cell_corner(n);
        if (at(q) != at(p) || cut[place_in_cell(pieces.fine, q)] & edges_from(n)) return;
      }
      whole[std::size_t(cell.first_fragment + at(p))]++;
    });
  }
};

/// Who a crumb goes with: by ways across a blade and back, which lead to its own side, and across only.
struct Votes {
  std::map<int, int> own_side, across;  // by part

  int part() const {
    const auto most = [](const std::map<int, int>& votes) {
      return std::max_element(votes.begin(), votes.end(),
                              [](const auto& a, const auto& b) { return a.second < b.second; })
          ->first;
    };
    return !own_side.empty() ? most(own_side) : !across.empty() ? most(across) : -1;
  }
};

struct SmallComponents {
  const FragmentView view;
  const Fragments& pieces;
  const std::vector<int>& part;                         // by piece
  const std::vector<std::uint8_t>& is_small_component;  // by piece
  std::map<int, Votes> votes;                           // by part

  /// Calls visit(neighbour in the cell, crossing) for the cut edges at a place of a cell.
  template <class Visit>
  void for_cut(const CutCell& cell, Int3 p, const Visit& visit) const {
    const FineLattice& f = pieces.fine;
    const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
    for (const Int3 family : kFamilies)
      for (const Int3 way : {family, -family})
        if (in_cell(f, p + way))
          if (const Crossing cut = crossing(view, first + p, first + p + way); cut.edge) visit(p + way, cut);
  }
  void count(const CutCell& cell) {
    const CellLabels labels{pieces, cell};
    const auto fragment_at = [&](Int3 p) {
      return labels.at(p) < 0 ? -1 : cell.first_fragment + labels.at(p);
    };
    const auto add = [&](std::map<int, int>& into, Int3 p) {
      if (const int piece = fragment_at(p); piece >= 0 && !is_small_component[std::size_t(piece)])
        into[part[std::size_t(piece)]]++;
    };
    for_places(pieces.fine, [&](Int3 p) {
      const int piece = fragment_at(p);
      if (piece < 0 || !is_small_component[std::size_t(piece)]) return;
      Votes& mine = votes[part[std::size_t(piece)]];
      for_cut(cell, p, [&](Int3 beside, const Crossing& out) {
        add(mine.across, beside);
        for_cut(cell, beside, [&](Int3 back, const Crossing& in) {
          if (in.edge->incision == out.edge->incision && in.rightward != out.rightward)
            add(mine.own_side, back);
        });
      });
    });
  }
  /// The piece of the part that a crumb goes with, in a cell; -1: there is none.
  int host(const CutCell& cell, int crumb) const {
    const auto found = votes.find(part[std::size_t(crumb)]);
    const int wanted = found == votes.end() ? -1 : found->second.part();
    for (int p = cell.first_fragment; p < cell.first_fragment + cell.fragment_count; p++)
      if (part[std::size_t(p)] == wanted) return p;
    return -1;
  }
};

void forget_unused_copies(Fragments& out) {
  const int slots = slot_count(out.fine.cells);
  std::vector<int> number(out.virtual_nodes.size(), -1);
  for (const Fragment& piece : out.pieces)
    for (const int corner : piece.corner)
      if (corner >= slots) number[std::size_t(corner - slots)] = 0;
  std::size_t count = 0;
  for (std::size_t c = 0; c < number.size(); c++)
    if (number[c] == 0) number[c] = int(count), out.virtual_nodes[count++] = out.virtual_nodes[c];
  out.virtual_nodes.resize(count);
  for (Fragment& piece : out.pieces)
    for (int& corner : piece.corner)
      if (corner >= slots) corner = slots + number[std::size_t(corner - slots)];
}

}  // namespace

void merge_small_components(const State& state, Fragments& out) {
  const std::vector<int> part = parts_of(out);
  std::vector<int> whole(out.pieces.size());
  for (const CutCell& cell : out.cells) CellLabels{out, cell}.count_whole(whole);
  std::vector<int> of_part(out.pieces.size());
  for (std::size_t p = 0; p < part.size(); p++) of_part[std::size_t(part[p])] += whole[p];
  const int least = out.fine.parts.x * out.fine.parts.y * out.fine.parts.z;
  std::vector<std::uint8_t> is_small_component(out.pieces.size());
  bool any = false;
  for (std::size_t p = 0; p < part.size(); p++)
    any |= is_small_component[p] = of_part[std::size_t(part[p])] < least;
  if (!any) return;
  SmallComponents crumbs{.view = view(out, state),
                         .pieces = out,
                         .part = part,
                         .is_small_component = is_small_component,
                         .votes = {}};
  for (const CutCell& cell : out.cells) crumbs.count(cell);
  std::map<int, int> instead;  // of a crumb's corners
  for (const CutCell& cell : out.cells)
    for (int p = cell.first_fragment; p < cell.first_fragment + cell.fragment_count; p++)
      if (is_small_component[std::size_t(p)])
        if (const int host = crumbs.host(cell, p); host >= 0)
          for (std::size_t c = 0; c < 8; c++)
            instead.try_emplace(out.pieces[std::size_t(p)].corner[c],
                                out.pieces[std::size_t(host)].corner[c]);
  for (std::size_t p = 0; p < part.size(); p++)
    if (is_small_component[p])
      for (int& corner : out.pieces[p].corner)
        if (const auto found = instead.find(corner); found != instead.end()) corner = found->second;
  forget_unused_copies(out);
}

}  // namespace turgor::lattice

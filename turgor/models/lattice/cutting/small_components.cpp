#include "turgor/models/lattice/cutting/small_components.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

/// Component of each fragment. Fragments with a common corner are connected.
std::vector<int> components_of(const Fragments& fragments) {
  std::vector<int> component(fragments.all.size());
  std::iota(component.begin(), component.end(), 0);
  std::vector<std::pair<int, int>> of_corner;  // corner, fragment
  for (int p = 0; p < int(component.size()); p++)
    for (const int corner : fragments.all[std::size_t(p)].corner) of_corner.emplace_back(corner, p);
  std::sort(of_corner.begin(), of_corner.end());
  // join consecutive fragments with the same corner
  for (std::size_t n = 1; n < of_corner.size(); n++)
    if (of_corner[n].first == of_corner[n - 1].first)
      join_sets(component, of_corner[n - 1].second, of_corner[n].second);
  for (int p = 0; p < int(component.size()); p++) component[std::size_t(p)] = root_of(component, p);
  return component;
}

/// Labels of one cell by sub-lattice node.
struct CellLabels {
  const Fragments& fragments;
  const CutCell& cell;

  int at(Int3 p) const {
    return fragments.label[cell.first_sub_index + std::size_t(sub_index(fragments.fine, p))];
  }
  /// Counts the sub-cells that lie in one fragment and have no cut edge, per fragment.
  void count_whole(std::vector<int>& whole) const {
    const std::uint8_t* cut = &fragments.cut_bits[cell.first_sub_index];
    for_sub_nodes(fragments.fine, [&](Int3 p) {
      if (!in_cell(fragments.fine, p + Int3{1, 1, 1}) || at(p) < 0) return;
      for (int n = 0; n < 8; n++) {
        const Int3 q = p + cell_corner(n);
        if (at(q) != at(p) || cut[sub_index(fragments.fine, q)] & edges_from(n)) return;
      }
      whole[std::size_t(cell.first_fragment + at(p))]++;
    });
  }
};

/// Votes of a small component for the component that absorbs it: one vote per path over cut edges. A path
/// across a blade and back ends on the side where it began. Such paths decide; paths that cross the blade
/// only once count if there are none.
struct Votes {
  std::map<int, int> own_side, across;  // number of votes, by component

  int winner() const {
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
  const Fragments& fragments;
  const std::vector<int>& component;                    // by fragment
  const std::vector<std::uint8_t>& is_small_component;  // by fragment
  std::map<int, Votes> votes;                           // by component

  /// Calls visit(neighbor in the cell, crossing) for the cut edges at a sub-lattice node.
  template <class Visit>
  void for_cut(const CutCell& cell, Int3 p, const Visit& visit) const {
    const FineLattice& f = fragments.fine;
    const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot));
    for (const Int3 family : kFamilies)
      for (const Int3 offset : {family, -family})
        if (in_cell(f, p + offset))
          if (const Crossing cut = crossing(view, first + p, first + p + offset); cut.edge)
            visit(p + offset, cut);
  }
  void count(const CutCell& cell) {
    // components that are not small receive votes
    const CellLabels labels{fragments, cell};
    const auto fragment_at = [&](Int3 p) {
      return labels.at(p) < 0 ? -1 : cell.first_fragment + labels.at(p);
    };
    const auto add = [&](std::map<int, int>& into, Int3 p) {
      if (const int fragment = fragment_at(p); fragment >= 0 && !is_small_component[std::size_t(fragment)])
        into[component[std::size_t(fragment)]]++;
    };
    // votes along paths from each fine node of a small component
    for_sub_nodes(fragments.fine, [&](Int3 p) {
      const int fragment = fragment_at(p);
      if (fragment < 0 || !is_small_component[std::size_t(fragment)]) return;
      Votes& own_votes = votes[component[std::size_t(fragment)]];
      for_cut(cell, p, [&](Int3 across_cut, const Crossing& out) {
        add(own_votes.across, across_cut);
        for_cut(cell, across_cut, [&](Int3 back, const Crossing& in) {
          if (in.edge->incision == out.edge->incision && in.rightward != out.rightward)
            add(own_votes.own_side, back);
        });
      });
    });
  }
  /// Fragment of the absorbing component in the same cell, or -1.
  int absorbing_fragment(const CutCell& cell, int fragment) const {
    TURGOR_CHECK(is_index(fragment, component.size()), "a fragment has a component");
    const auto found = votes.find(component[std::size_t(fragment)]);
    const int wanted = found == votes.end() ? -1 : found->second.winner();
    for (int p = cell.first_fragment; p < cell.first_fragment + cell.fragment_count; p++)
      if (component[std::size_t(p)] == wanted) return p;
    return -1;
  }
};

/// Copies the number of whole sub-cells in the fragments of a cell.
void copy_whole(const Fragments& before, int index, const CutCell& cell, std::vector<int>& whole) {
  const auto from = before.stages.whole.begin() + before.cells[std::size_t(index)].first_fragment;
  std::copy(from, from + cell.fragment_count, whole.begin() + cell.first_fragment);
}

void remove_unused_virtual_nodes(Fragments& out) {
  const int slots = slot_count(out.fine.cells);
  // mark used virtual nodes
  std::vector<int> number(out.virtual_nodes.size(), -1);
  for (const Fragment& fragment : out.all)
    for (const int corner : fragment.corner)
      if (corner >= slots) number[std::size_t(corner - slots)] = 0;
  // compact the list
  std::size_t count = 0;
  for (std::size_t c = 0; c < number.size(); c++)
    if (number[c] == 0) number[c] = int(count), out.virtual_nodes[count++] = out.virtual_nodes[c];
  out.virtual_nodes.resize(count);
  // renumber corners
  for (Fragment& fragment : out.all)
    for (int& corner : fragment.corner)
      if (corner >= slots) corner = slots + number[std::size_t(corner - slots)];
}

}  // namespace

void merge_small_components(const Cuts& cuts, const EarlierFragments& earlier, Fragments& out) {
  // whole sub-cells of each component
  const std::vector<int> component = components_of(out);
  std::vector<int>& whole = out.stages.whole;
  whole.assign(out.all.size(), 0);
  for (const CutCell& cell : out.cells)
    if (const int index = earlier.index(out, cell); index >= 0)
      copy_whole(*earlier.fragments, index, cell, whole);
    else
      CellLabels{out, cell}.count_whole(whole);
  std::vector<int> whole_in_component(out.all.size());
  for (std::size_t p = 0; p < component.size(); p++)
    whole_in_component[std::size_t(component[p])] += whole[p];
  // a component with fewer whole sub-cells than one cell is small
  const int least = out.fine.subdivisions.x * out.fine.subdivisions.y * out.fine.subdivisions.z;
  std::vector<std::uint8_t> is_small_component(out.all.size());
  bool any = false;
  for (std::size_t p = 0; p < component.size(); p++)
    any |= is_small_component[p] = whole_in_component[std::size_t(component[p])] < least;
  if (!any) return;
  // votes for absorbing components
  SmallComponents small{.view = view(out, cuts),
                        .fragments = out,
                        .component = component,
                        .is_small_component = is_small_component,
                        .votes = {}};
  for (const CutCell& cell : out.cells) small.count(cell);
  std::map<int, int> replacement;  // corner of a small component → corner that replaces it
  for (const CutCell& cell : out.cells)
    for (int p = cell.first_fragment; p < cell.first_fragment + cell.fragment_count; p++)
      if (is_small_component[std::size_t(p)])
        if (const int absorbing = small.absorbing_fragment(cell, p); absorbing >= 0)
          for (std::size_t c = 0; c < 8; c++)
            replacement.try_emplace(out.all[std::size_t(p)].corner[c],
                                    out.all[std::size_t(absorbing)].corner[c]);
  // replace corners
  for (std::size_t p = 0; p < component.size(); p++)
    if (is_small_component[p])
      for (int& corner : out.all[p].corner)
        if (const auto found = replacement.find(corner); found != replacement.end()) corner = found->second;
  remove_unused_virtual_nodes(out);
}

}  // namespace turgor::lattice

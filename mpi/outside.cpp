#include "mpi/outside.hpp"

#include <algorithm>
#include <compare>
#include <numeric>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/geometry/row_components.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::mpi {

namespace {

using Mask = std::vector<std::uint8_t>;

/// A connected component of owned layers.
struct Component {
  std::int64_t size = 0;
  bool is_at_side = false;
};
/// Components of all processes, joined across borders. They are numbered by rank, and within a rank in the
/// order of their first nodes. The lowest number of a joined set is its root.
struct JoinedComponents {
  RowComponents owned;
  std::size_t first_own = 0;  // number of the first component of this process
  std::vector<int> root;
  std::vector<Component> whole;  // merged component of each root

  int root_of(int own_component) const { return root[first_own + std::size_t(own_component)]; }
};

/// Component numbers in one owned layer; −1 outside the mask.
std::vector<int> components_of_layer(const JoinedComponents& components, Int3 size, int layer) {
  std::vector<int> found(std::size_t(size.x) * std::size_t(size.y), -1);
  for (const CellRun& run : components.owned.runs)
    if (run.k == layer)
      std::fill_n(found.begin() + (std::ptrdiff_t(run.j) * size.x + run.begin), run.end - run.begin,
                  int(components.first_own) + run.component);
  return found;
}

/// Two components that touch.
struct ComponentPair {
  int below, above;

  friend auto operator<=>(const ComponentPair&, const ComponentPair&) = default;
};
/// Pairs of components that touch between the last layer of the rank below and the first one of this rank.
std::vector<ComponentPair> touching_components(const Ranks& ranks, const JoinedComponents& components,
                                               Int3 size) {
  const std::vector<int> top = components_of_layer(components, size, size.z - 1),
                         bottom = components_of_layer(components, size, 0);
  std::vector<int> below(top.size(), -1);
  pass(ranks, ranks.rank + 1, std::as_bytes(std::span(top)), ranks.rank - 1,
       std::as_writable_bytes(std::span(below)));
  std::vector<ComponentPair> touching;
  for (std::size_t n = 0; n < bottom.size(); n++)
    if (below[n] >= 0 && bottom[n] >= 0) touching.push_back({below[n], bottom[n]});
  std::sort(touching.begin(), touching.end());
  touching.erase(std::unique(touching.begin(), touching.end()), touching.end());
  return touching;
}

/// Connected components of a mask of owned layers, over all ranks.
JoinedComponents join_components(const Ranks& ranks, const Grid& nodes, Layers owned, const Mask& mask) {
  const Int3 size{nodes.size.x, nodes.size.y, owned.end - owned.begin};
  JoinedComponents components{.owned = row_components(mask, size), .root = {}, .whole = {}};
  std::vector<Component> mine(components.owned.sizes.size());
  const int across = (lattice::long_axis(nodes) + 1) % 3, other = (across + 1) % 3;
  for (const CellRun& run : components.owned.runs) {
    Component& component = mine[std::size_t(run.component)];
    component.size += run.end - run.begin;
    for (const int i : {run.begin, run.end - 1}) {
      const Int3 p{i, run.j, owned.begin + run.k};
      component.is_at_side |=
          lattice::is_at_end(p, nodes.size, across) || lattice::is_at_end(p, nodes.size, other);
    }
  }
  const std::vector<std::int64_t> counts = join(ranks, std::vector<std::int64_t>{std::int64_t(mine.size())});
  components.first_own =
      std::size_t(std::accumulate(counts.begin(), counts.begin() + ranks.rank, std::int64_t(0)));
  components.whole = join(ranks, mine);
  components.root.resize(components.whole.size());
  std::iota(components.root.begin(), components.root.end(), 0);
  for (const auto& [a, b] : join(ranks, touching_components(ranks, components, size)))
    join_sets(components.root, a, b);
  for (int p = 0; p < int(components.root.size()); p++) {
    const int root = turgor::root_of(components.root, p);
    components.root[std::size_t(p)] = root;
    if (root == p) continue;
    Component &whole = components.whole[std::size_t(root)], &component = components.whole[std::size_t(p)];
    whole.size += component.size, whole.is_at_side |= component.is_at_side;
    component = {};
  }
  return components;
}

/// Mask of owned nodes whose component is wanted.
template <class Wanted>
Mask marked(const JoinedComponents& components, const Grid& nodes, std::size_t count, const Wanted& wanted) {
  Mask mask(count);
  for (const CellRun& run : components.owned.runs)
    if (wanted(components.root_of(run.component)))
      std::fill_n(mask.begin() + std::ptrdiff_t(sample_index(nodes, run.begin, run.j, run.k)),
                  run.end - run.begin, std::uint8_t(1));
  return mask;
}

}  // namespace

Mask find_outside(const Ranks& ranks, const Grid& nodes, Layers owned, const std::vector<std::int16_t>& hu,
                  double air_max) {
  Mask air(hu.size());
  for (std::size_t n = 0; n < hu.size(); n++) air[n] = hu[n] < air_max;
  const JoinedComponents of_air = join_components(ranks, nodes, owned, air);
  Mask rest =
      marked(of_air, nodes, hu.size(), [&](int root) { return of_air.whole[std::size_t(root)].is_at_side; });
  for (std::uint8_t& node : rest) node = 1 - node;
  const JoinedComponents of_rest = join_components(ranks, nodes, owned, rest);
  int largest = -1;
  for (std::size_t p = 0; p < of_rest.whole.size(); p++)
    if (const auto size = of_rest.whole[p].size;
        size > (largest < 0 ? 0 : of_rest.whole[std::size_t(largest)].size))
      largest = int(p);
  if (largest < 0) return {};
  Mask body = marked(of_rest, nodes, hu.size(), [&](int root) { return root == largest; });
  for (std::uint8_t& node : body) node = 1 - node;
  return body;
}

}  // namespace turgor::mpi

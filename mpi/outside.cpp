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

/// A connected part of own layers.
struct Part {
  std::int64_t size = 0;
  bool is_at_side = false;
};
/// Parts of all processes that are one: in the order of ranks, those of one rank in the order of their first
/// nodes. The lowest number of those that are joined stands for them.
struct JoinedParts {
  RowComponents owned;
  std::size_t first_own = 0;  // own part 0 has this number
  std::vector<int> root;
  std::vector<Part> whole;  // of roots

  int root_of(int own_part) const { return root[first_own + std::size_t(own_part)]; }
};

/// The numbers of parts in one own layer, −1 where there is none.
std::vector<int> layer_of_parts(const JoinedParts& parts, Int3 size, int layer) {
  std::vector<int> found(std::size_t(size.x) * std::size_t(size.y), -1);
  for (const CellRun& run : parts.owned.runs)
    if (run.k == layer)
      std::fill_n(found.begin() + (std::ptrdiff_t(run.j) * size.x + run.begin), run.end - run.begin,
                  int(parts.first_own) + run.part);
  return found;
}

/// Two parts that are one.
struct CcdPair {
  int below, above;

  friend auto operator<=>(const CcdPair&, const CcdPair&) = default;
};
/// Which parts meet between the last layer of the rank below and the first one here.
std::vector<CcdPair> meeting_parts(const Ranks& ranks, const JoinedParts& parts, Int3 size) {
  const std::vector<int> top = layer_of_parts(parts, size, size.z - 1),
                         bottom = layer_of_parts(parts, size, 0);
  std::vector<int> below(top.size(), -1);
  pass(ranks, ranks.rank + 1, std::as_bytes(std::span(top)), ranks.rank - 1,
       std::as_writable_bytes(std::span(below)));
  std::vector<CcdPair> met;
  for (std::size_t n = 0; n < bottom.size(); n++)
    if (below[n] >= 0 && bottom[n] >= 0) met.push_back({below[n], bottom[n]});
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
  return met;
}

/// Connected parts of a mask of own layers, over all ranks.
JoinedParts join_parts(const Ranks& ranks, const Grid& nodes, Layers owned, const Mask& mask) {
  const Int3 size{nodes.size.x, nodes.size.y, owned.end - owned.begin};
  JoinedParts parts{.owned = row_components(mask, size), .root = {}, .whole = {}};
  std::vector<Part> mine(parts.owned.sizes.size());
  const int across = (lattice::long_axis(nodes) + 1) % 3, other = (across + 1) % 3;
  for (const CellRun& run : parts.owned.runs) {
    Part& part = mine[std::size_t(run.part)];
    part.size += run.end - run.begin;
    for (const int i : {run.begin, run.end - 1}) {
      const Int3 p{i, run.j, owned.begin + run.k};
      part.is_at_side |=
          lattice::is_at_end(p, nodes.size, across) || lattice::is_at_end(p, nodes.size, other);
    }
  }
  const std::vector<std::int64_t> counts = join(ranks, std::vector<std::int64_t>{std::int64_t(mine.size())});
  parts.first_own =
      std::size_t(std::accumulate(counts.begin(), counts.begin() + ranks.rank, std::int64_t(0)));
  parts.whole = join(ranks, mine);
  parts.root.resize(parts.whole.size());
  std::iota(parts.root.begin(), parts.root.end(), 0);
  for (const auto& [a, b] : join(ranks, meeting_parts(ranks, parts, size))) join_sets(parts.root, a, b);
  for (int p = 0; p < int(parts.root.size()); p++) {
    const int root = turgor::root_of(parts.root, p);
    parts.root[std::size_t(p)] = root;
    if (root == p) continue;
    Part &whole = parts.whole[std::size_t(root)], &part = parts.whole[std::size_t(p)];
    whole.size += part.size, whole.is_at_side |= part.is_at_side;
    part = {};
  }
  return parts;
}

/// Marks own nodes whose part is wanted.
template <class Wanted>
Mask marked(const JoinedParts& parts, const Grid& nodes, std::size_t count, const Wanted& wanted) {
  Mask mask(count);
  for (const CellRun& run : parts.owned.runs)
    if (wanted(parts.root_of(run.part)))
      std::fill_n(mask.begin() + std::ptrdiff_t(sample_index(nodes, run.begin, run.j, run.k)),
                  run.end - run.begin, std::uint8_t(1));
  return mask;
}

}  // namespace

Mask find_outside(const Ranks& ranks, const Grid& nodes, Layers owned, const std::vector<std::int16_t>& hu,
                  double air_max) {
  Mask air(hu.size());
  for (std::size_t n = 0; n < hu.size(); n++) air[n] = hu[n] < air_max;
  const JoinedParts of_air = join_parts(ranks, nodes, owned, air);
  Mask rest =
      marked(of_air, nodes, hu.size(), [&](int root) { return of_air.whole[std::size_t(root)].is_at_side; });
  for (std::uint8_t& node : rest) node = 1 - node;
  const JoinedParts of_rest = join_parts(ranks, nodes, owned, rest);
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

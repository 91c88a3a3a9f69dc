#include "turgor/models/cloth/ccd/ccd_zones.hpp"

#include <algorithm>
#include <array>

#include "turgor/core/assert.hpp"
#include "turgor/core/disjoint_sets.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

namespace {

/// Calls visit(corner, other) for the vertices of a chunk and their neighbors in its triangles, except
/// slivers.
template <class Visit>
void visit_neighbors_of(const Model& model, std::size_t chunk, const Visit& visit) {
  const ChunkTriangles& chunks = model.chunk_triangles;
  const auto is_mine = [&](int v) { return std::size_t(v) / kChunk == chunk; };
  for (int n = chunks.begin[chunk]; n < chunks.begin[chunk + 1]; n++) {
    const auto t = std::size_t(chunks.triangle[std::size_t(n)]);
    if (model.membrane.is_sliver(t)) continue;
    const Int3& corners = model.triangles[t];
    for (int k = 0; k < 3; k++)
      for (int l = 0; l < 3; l++)
        if (k != l && is_mine(corners[k])) visit(std::size_t(corners[k]), std::size_t(corners[l]));
  }
}

}  // namespace

std::size_t ccd_leaves(const Model& model) { return (std::size_t(model.count) + kLeaf - 1) / kLeaf; }

void join_zones(CcdWorkspace& ccd, std::size_t first, std::vector<int>& joined) {
  auto &in_impact_zone = ccd.in_impact_zone, &zone = ccd.zone;
  // union of the vertices of each pair
  for (std::size_t n = first; n < ccd.ccd_pairs.size(); n++) {
    const std::array<int, 4>& vertex = ccd.ccd_pairs[n].vertex;
    for (const int v : vertex)
      if (joined[std::size_t(v)] < 0) joined[std::size_t(v)] = v;
    for (std::size_t k = 1; k < 4; k++) join_sets(joined, vertex[0], vertex[k]);
  }
  // vertices of all pairs; a root is the smallest of its zone, so its index is known
  in_impact_zone.clear(), zone.clear();
  std::vector<int> index(joined.size());
  for (int v = 0; v < int(joined.size()); v++) {
    if (joined[std::size_t(v)] < 0) continue;
    index[std::size_t(v)] = int(in_impact_zone.size());
    in_impact_zone.push_back(v);
    zone.push_back(index[std::size_t(root_of(joined, v))]);
  }
  TURGOR_CHECK(all_indices(zone, zone.size()), "a zone is named by one of its vertices");
}

ZoneOfVertex zone_of_vertices(const Model& model, const CcdWorkspace& ccd) {
  ZoneOfVertex zone(ccd_leaves(model) * kLeaf, -1);
  for (std::size_t n = 0; n < ccd.in_impact_zone.size(); n++)
    zone[std::size_t(ccd.in_impact_zone[n])] = ccd.zone[n];
  return zone;
}

ZoneOfVertex zones_of_stars(const Exec& exec, const Model& model, const ZoneOfVertex& zone) {
  ZoneOfVertex of_star = zone;
  parallel_for(exec, model.chunk_triangles.begin.size() - 1, [&](std::size_t chunk) {
    visit_neighbors_of(model, chunk, [&](std::size_t v, std::size_t other) {
      if (zone[other] != zone[v]) of_star[v] = -1;
    });
  });
  return of_star;
}

std::vector<int> zones_of_boxes(const Exec& exec, const Model& model, const CcdWorkspace& ccd,
                                const ZoneOfVertex& of_star) {
  std::vector<int> of_box(ccd.boxes.size());
  parallel_for(
      exec, ccd.level_begin[1],
      [&](std::size_t leaf) {
        const auto first = of_star.begin() + std::ptrdiff_t(leaf * kLeaf),
                   end = of_star.begin() +
                         std::ptrdiff_t(std::min((leaf + 1) * kLeaf, std::size_t(model.count)));
        of_box[leaf] = std::all_of(first, end, [&](int zone) { return zone == *first; }) ? *first : -1;
      },
      64);
  for (std::size_t level = 1; level + 1 < ccd.level_begin.size(); level++) {
    const std::size_t below = ccd.level_begin[level - 1], begin = ccd.level_begin[level];
    for (std::size_t n = begin; n < ccd.level_begin[level + 1]; n++) {
      const std::size_t first = below + 2 * (n - begin), second = std::min(first + 1, begin - 1);
      of_box[n] = of_box[first] == of_box[second] ? of_box[first] : -1;
    }
  }
  return of_box;
}

void mark_changed(const Exec& exec, const Model& model, const std::vector<int>& changed, CcdWorkspace& ccd) {
  std::vector<char> itself(ccd_leaves(model) * kLeaf, 0);
  for (const int v : changed) itself[std::size_t(v)] = 1;
  ccd.is_changed = itself;
  parallel_for(exec, model.chunk_triangles.begin.size() - 1, [&](std::size_t chunk) {
    visit_neighbors_of(model, chunk, [&](std::size_t v, std::size_t other) {
      if (itself[other]) ccd.is_changed[v] = 1;
    });
  });
}

}  // namespace turgor::cloth

#include "turgor/models/cloth/build/large.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/surface_edges.hpp"

namespace turgor::cloth {

namespace {

double longest_side(const TriMesh& mesh, Int3 t) {
  double longest = 0;
  for (int side = 0; side < 3; side++)
    longest = std::max(longest, norm(Vec3d(mesh.vertices[std::size_t(t[side])]) -
                                     Vec3d(mesh.vertices[std::size_t(t[(side + 1) % 3])])));
  return longest;
}

/// Lists the edges of the large triangles, ascending, with the corners that face them. An edge of three
/// triangles has none: nothing bounds its contacts.
void find_large_edges(LargePrimitives& large) {
  large.across.assign(large.triangles.size(), {-1, -1, -1});
  const std::vector<EdgeUse> uses = sorted_edges(large.triangles);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    const auto facing = [&](const EdgeUse& use) {
      return large.triangles[std::size_t(use.triangle)][(use.side + 2) % 3];
    };
    std::array<int, 2> corners{-1, -1};
    if (edge.size() <= 2)
      for (std::size_t k = 0; k < edge.size(); k++) corners[k] = facing(edge[k]);
    large.edges.push_back({edge[0].a, edge[0].b});
    large.facing.push_back(corners);
    if (edge.size() != 2) return;
    for (std::size_t k = 0; k < 2; k++)
      large.across[std::size_t(edge[k].triangle)][(edge[k].side + 2) % 3] = corners[1 - k];
  });
}

/// Lists the neighbors of all vertices whose triangles are all large; `touches_small` marks the others.
NeighborLists find_large_stars(const LargePrimitives& large, const std::vector<char>& touches_small) {
  std::vector<std::vector<int>> lists(touches_small.size());
  for (const Int3 t : large.triangles)
    for (int k = 0; k < 3; k++)
      if (!touches_small[std::size_t(t[k])])
        for (const int other : {t[(k + 1) % 3], t[(k + 2) % 3]}) lists[std::size_t(t[k])].push_back(other);
  NeighborLists stars;
  stars.begin.push_back(0);
  for (std::vector<int>& list : lists) {
    sort_unique(list);
    stars.item.insert(stars.item.end(), list.begin(), list.end());
    stars.begin.push_back(int(stars.item.size()));
  }
  TURGOR_CHECK(is_csr(stars.begin, stars.item.size()), "every vertex has a list of neighbors");
  return stars;
}

}  // namespace

// Vertex contacts keep two sheets apart if edges are about as long as the thickness: edges of √2 times that
// length that cross at their midpoints have ends one thickness apart. Small triangles beside large ones are
// included, so that the normal cones of their vertices are known.
LargePrimitives find_large_primitives(const TriMesh& mesh, const Membrane& membrane, double thickness) {
  TURGOR_CHECK(thickness > 0, "contacts have a thickness");
  const auto for_triangles = [&](const auto& visit) {
    for (std::size_t n = 0; n < mesh.triangles.size(); n++)
      if (!membrane.is_sliver(n)) visit(mesh.triangles[n], longest_side(mesh, mesh.triangles[n]));
  };
  // vertices of triangles with a long side, and of others
  std::vector<char> touches_long(mesh.vertices.size(), 0), touches_small(mesh.vertices.size(), 0);
  const auto mark = [](Int3 t, std::vector<char>& marked) {
    for (int k = 0; k < 3; k++) marked[std::size_t(t[k])] = 1;
  };
  for_triangles([&](Int3 t, double longest) {
    if (longest > 1.5 * thickness) mark(t, touches_long);
  });
  // triangles around these vertices
  LargePrimitives large;
  for_triangles([&](Int3 t, double longest) {
    bool is_large = false;
    for (int k = 0; k < 3; k++) is_large = is_large || touches_long[std::size_t(t[k])];
    if (!is_large) return mark(t, touches_small);
    large.triangles.push_back(t);
    large.longest = std::max(large.longest, Real(longest));
  });
  if (large.triangles.empty()) return large;
  find_large_edges(large);
  large.stars = find_large_stars(large, touches_small);
  return large;
}

}  // namespace turgor::cloth

#include "turgor/geometry/manifold.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/surface_edges.hpp"

namespace turgor {

namespace {

/// A mesh with its adjacency.
struct Neighborhood {
  const SolidMesh& mesh;
  std::vector<int> neighbor;    // across each face of each element
  std::vector<int> star_begin;  // vertices + 1
  std::vector<int> star;        // elements of each vertex, ascending
  SolidSurface surface;
};

Neighborhood neighborhood(const SolidMesh& mesh) {
  Neighborhood around{mesh, face_neighbors(mesh), {}, {}, surface(mesh)};
  around.star_begin.assign(mesh.vertices.size() + 1, 0);
  for (const int v : mesh.elements) around.star_begin[std::size_t(v) + 1]++;
  std::partial_sum(around.star_begin.begin(), around.star_begin.end(), around.star_begin.begin());
  std::vector<int> next(around.star_begin.begin(), around.star_begin.end() - 1);
  around.star.resize(mesh.elements.size());
  for (std::size_t i = 0; i < mesh.elements.size(); i++)
    around.star[std::size_t(next[std::size_t(mesh.elements[i])]++)] = int(i / 4);
  return around;
}

std::span<const int> star_of(const Neighborhood& around, int v) {
  const auto begin = std::size_t(around.star_begin[std::size_t(v)]);
  return {around.star.data() + begin, std::size_t(around.star_begin[std::size_t(v) + 1]) - begin};
}

bool has_vertex(const SolidMesh& mesh, int e, int v) {
  const auto corners = element(mesh, std::size_t(e));
  return std::find(corners.begin(), corners.end(), v) != corners.end();
}

/// Groups of elements (ascending) that are connected by faces containing vertex v, and vertex w unless it is
/// -1. Each element's group is identified by its first element.
std::vector<int> groups_around(const Neighborhood& around, std::span<const int> elements, int v, int w) {
  std::vector<int> group(elements.size());
  std::iota(group.begin(), group.end(), 0);
  const auto faces = element_faces(around.mesh);
  const auto join = [&](std::size_t i, std::size_t f) {
    const int e = elements[i], other = around.neighbor[std::size_t(e) * 4 + f];
    const auto found = std::lower_bound(elements.begin(), elements.end(), other);
    if (found == elements.end() || *found != other) return;
    const auto has = [&](int vertex) {
      for (std::size_t c = 0; c < 3; c++)
        if (element(around.mesh, std::size_t(e))[std::size_t(faces[f][c])] == vertex) return true;
      return false;
    };
    if (!has(v) || (w >= 0 && !has(w))) return;
    const int a = group[i], b = group[std::size_t(found - elements.begin())];
    if (a != b) std::replace(group.begin(), group.end(), std::max(a, b), std::min(a, b));
  };
  for (std::size_t i = 0; i < elements.size(); i++)
    for (std::size_t f = 0; f < 4; f++) join(i, f);
  return group;
}

/// Removes all groups except the one with the largest volume.
void remove_smaller_groups(const SolidMesh& mesh, std::span<const int> elements, std::span<const int> group,
                           std::vector<std::uint8_t>& keep) {
  std::vector<double> size(elements.size(), 0);
  for (std::size_t i = 0; i < elements.size(); i++)
    size[std::size_t(group[i])] += volume(mesh, std::size_t(elements[i]));
  const auto largest = int(std::max_element(size.begin(), size.end()) - size.begin());
  for (std::size_t i = 0; i < elements.size(); i++)
    if (group[i] != largest) keep[std::size_t(elements[i])] = 0;
}

/// Repairs edges at which more than two surface triangles meet.
void open_crowded_edges(const Neighborhood& around, std::vector<std::uint8_t>& keep) {
  const std::vector<EdgeUse> edges = sorted_edges(around.surface.triangles);
  for_each_edge(edges, [&](std::span<const EdgeUse> uses) {
    if (uses.size() <= 2) return;
    std::vector<int> ring;
    for (const int e : star_of(around, uses[0].a))
      if (has_vertex(around.mesh, e, uses[0].b)) ring.push_back(e);
    remove_smaller_groups(around.mesh, ring, groups_around(around, ring, uses[0].a, uses[0].b), keep);
  });
}

/// Surface triangles at each vertex.
struct SurfaceStar {
  std::vector<int> begin, triangle;
};

SurfaceStar surface_star(const Neighborhood& around) {
  SurfaceStar star;
  star.begin.assign(around.mesh.vertices.size() + 1, 0);
  for (const Int3 t : around.surface.triangles)
    for (int c = 0; c < 3; c++) star.begin[std::size_t(t[c]) + 1]++;
  std::partial_sum(star.begin.begin(), star.begin.end(), star.begin.begin());
  std::vector<int> next(star.begin.begin(), star.begin.end() - 1);
  star.triangle.resize(around.surface.triangles.size() * 3);
  for (std::size_t t = 0; t < around.surface.triangles.size(); t++)
    for (int c = 0; c < 3; c++)
      star.triangle[std::size_t(next[std::size_t(around.surface.triangles[t][c])]++)] = int(t);
  return star;
}

/// Number of rings that the triangles at a vertex form, if every edge has two of them.
int count_rings(const Neighborhood& around, std::span<const int> triangles, int v) {
  const auto after = [&](const Int3 t, int step) {  // corner `step` after v
    return t.x == v ? t[step] : t.y == v ? t[(1 + step) % 3] : t[(2 + step) % 3];
  };
  std::vector<std::uint8_t> visited(triangles.size(), 0);
  int rings = 0;
  for (std::size_t first = 0; first < triangles.size(); first++) {
    if (visited[first]) continue;
    rings++;
    for (std::size_t i = first; !visited[i];) {
      visited[i] = 1;
      const int leaving = after(around.surface.triangles[std::size_t(triangles[i])], 2);
      for (std::size_t j = 0; j < triangles.size(); j++)
        if (!visited[j] && after(around.surface.triangles[std::size_t(triangles[j])], 1) == leaving) {
          i = j;
          break;
        }
    }
  }
  return rings;
}

/// Removes all elements at vertices where one group of elements has several surface rings.
void open_pierced_vertices(const Neighborhood& around, std::vector<std::uint8_t>& keep) {
  const SurfaceStar star = surface_star(around);
  for (std::size_t v = 0; v + 1 < star.begin.size(); v++) {
    const std::span triangles(star.triangle.data() + star.begin[v],
                              std::size_t(star.begin[v + 1] - star.begin[v]));
    if (triangles.empty() || count_rings(around, triangles, int(v)) == 1) continue;
    const std::span<const int> elements = star_of(around, int(v));
    std::vector<int> group = groups_around(around, elements, int(v), -1);
    std::sort(group.begin(), group.end());
    const auto groups = std::unique(group.begin(), group.end()) - group.begin();
    if (count_rings(around, triangles, int(v)) == groups) continue;
    for (const int e : elements) keep[std::size_t(e)] = 0;
  }
}

/// Gives every group of elements that meet in a single vertex its own vertex.
void split_vertices(SolidMesh& mesh) {
  const SolidMesh before = mesh;
  const Neighborhood around = neighborhood(before);
  std::vector<std::uint8_t> on_surface(before.vertices.size(), 0);
  for (const Int3 t : around.surface.triangles)
    for (int c = 0; c < 3; c++) on_surface[std::size_t(t[c])] = 1;
  for (std::size_t v = 0; v < before.vertices.size(); v++) {
    if (!on_surface[v]) continue;
    const std::span<const int> elements = star_of(around, int(v));
    const std::vector<int> group = groups_around(around, elements, int(v), -1);
    std::vector<int> vertex(elements.size(), int(v));  // of each group
    for (std::size_t i = 0; i < elements.size(); i++) {
      if (group[i] == int(i) && i > 0) {
        vertex[i] = int(mesh.vertices.size());
        mesh.vertices.push_back(before.vertices[v]);
      }
      for (std::size_t c = 0; c < 4; c++)
        if (int& corner = mesh.elements[std::size_t(elements[i]) * 4 + c]; corner == int(v))
          corner = vertex[std::size_t(group[i])];
    }
  }
}

}  // namespace

SolidMesh kept_elements(const SolidMesh& mesh, std::span<const std::uint8_t> keep) {
  SolidMesh result;
  result.corners = mesh.corners;
  // number the vertices in use
  std::vector<int> number(mesh.vertices.size(), -1);
  for (std::size_t e = 0; e < element_count(mesh); e++)
    if (keep[e])
      for (const int v : element(mesh, e)) number[std::size_t(v)] = 0;
  for (std::size_t v = 0; v < number.size(); v++)
    if (number[v] == 0) {
      number[v] = int(result.vertices.size());
      result.vertices.push_back(mesh.vertices[v]);
    }
  // copy the kept elements
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    if (!keep[e]) continue;
    for (const int v : element(mesh, e)) result.elements.push_back(number[std::size_t(v)]);
    if (!mesh.regions.empty()) result.regions.push_back(mesh.regions[e]);
  }
  return result;
}

SolidMesh make_manifold(SolidMesh mesh) {
  TURGOR_ASSERT(mesh.corners == 4, "only tetrahedra are made manifold");
  for (bool changed = true; changed;) {
    std::vector<std::uint8_t> keep(element_count(mesh), 1);
    const Neighborhood around = neighborhood(mesh);
    open_crowded_edges(around, keep);
    changed = std::count(keep.begin(), keep.end(), 0) > 0;
    if (!changed) open_pierced_vertices(around, keep);
    changed = std::count(keep.begin(), keep.end(), 0) > 0;
    if (changed) mesh = kept_elements(mesh, keep);
  }
  split_vertices(mesh);
  return mesh;
}

}  // namespace turgor

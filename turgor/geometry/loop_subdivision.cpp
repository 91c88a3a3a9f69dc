#include "turgor/geometry/loop_subdivision.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

/// Weighted sum of coarse vertices, ascending.
using Stencil = std::vector<std::pair<int, double>>;

/// Edge of the present triangles with its opposite corners.
struct MeshEdge {
  int a = 0, b = 0;  // a < b
  std::array<int, 2> opposite{};
  int triangles = 0;
  bool is_crease() const { return triangles != 2; }
};

struct Level {
  std::vector<Int3> triangles;
  std::vector<Stencil> vertices;
  std::vector<Stencil> on_coarse;  // the same without smoothing: at most three coarse vertices
};

Stencil sum_of(std::initializer_list<std::pair<const Stencil*, double>> terms) {
  std::map<int, double> sum;
  for (const auto& [stencil, factor] : terms)
    for (const auto& [vertex, weight] : *stencil) sum[vertex] += factor * weight;
  return {sum.begin(), sum.end()};
}

/// Edges in ascending order, and the three edges of every triangle: from x to y, y to z, z to x.
std::vector<MeshEdge> edges_of(const std::vector<Int3>& triangles, std::vector<Int3>& edges_of_triangle) {
  // sides of triangles, by edge
  struct Side {
    int a, b, opposite, triangle, corner;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < triangles.size(); t++)
    for (int c = 0; c < 3; c++) {
      const int a = triangles[t][c], b = triangles[t][(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), triangles[t][(c + 2) % 3], int(t), c});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::array{p.a, p.b, p.triangle, p.corner} < std::array{q.a, q.b, q.triangle, q.corner};
  });
  // join equal ones
  std::vector<MeshEdge> edges;
  edges_of_triangle.assign(triangles.size(), {});
  for (const Side& side : sides) {
    if (edges.empty() || edges.back().a != side.a || edges.back().b != side.b)
      edges.push_back({.a = side.a, .b = side.b});
    MeshEdge& edge = edges.back();
    if (edge.triangles < 2) edge.opposite[std::size_t(edge.triangles)] = side.opposite;
    edge.triangles++;
    edges_of_triangle[std::size_t(side.triangle)][side.corner] = int(edges.size()) - 1;
  }
  return edges;
}

/// Moved vertices of a level.
std::vector<Stencil> moved_vertices(const Level& level, const std::vector<MeshEdge>& edges) {
  std::vector<std::vector<int>> neighbors(level.vertices.size()), crease(level.vertices.size());
  for (const MeshEdge& edge : edges)
    for (const auto& [from, to] : {std::pair(edge.a, edge.b), std::pair(edge.b, edge.a)}) {
      neighbors[std::size_t(from)].push_back(to);
      if (edge.is_crease()) crease[std::size_t(from)].push_back(to);
    }
  std::vector<Stencil> moved(level.vertices.size());
  for (std::size_t v = 0; v < moved.size(); v++) {
    const Stencil& own = level.vertices[v];
    const double count = double(neighbors[v].size());
    if (crease[v].size() == 2) {
      moved[v] = sum_of({{&own, 0.75},
                         {&level.vertices[std::size_t(crease[v][0])], 0.125},
                         {&level.vertices[std::size_t(crease[v][1])], 0.125}});
    } else if (!crease[v].empty() || neighbors[v].empty()) {
      moved[v] = own;  // a corner
    } else {
      const double beta = count == 3 ? 3.0 / 16 : 3 / (8 * count);
      std::map<int, double> sum;
      for (const auto& [vertex, weight] : own) sum[vertex] += (1 - count * beta) * weight;
      for (const int n : neighbors[v])
        for (const auto& [vertex, weight] : level.vertices[std::size_t(n)]) sum[vertex] += beta * weight;
      moved[v] = {sum.begin(), sum.end()};
    }
  }
  return moved;
}

Level subdivided(const Level& level) {
  std::vector<Int3> edges_of_triangle;
  const std::vector<MeshEdge> edges = edges_of(level.triangles, edges_of_triangle);
  Level next{.triangles = {}, .vertices = moved_vertices(level, edges), .on_coarse = level.on_coarse};
  // one vertex an edge
  const int first = int(next.vertices.size());
  for (const MeshEdge& edge : edges) {
    const Stencil &a = level.vertices[std::size_t(edge.a)], &b = level.vertices[std::size_t(edge.b)];
    next.on_coarse.push_back(
        sum_of({{&level.on_coarse[std::size_t(edge.a)], 0.5}, {&level.on_coarse[std::size_t(edge.b)], 0.5}}));
    if (edge.is_crease())
      next.vertices.push_back(sum_of({{&a, 0.5}, {&b, 0.5}}));
    else
      next.vertices.push_back(sum_of({{&a, 0.375},
                                      {&b, 0.375},
                                      {&level.vertices[std::size_t(edge.opposite[0])], 0.125},
                                      {&level.vertices[std::size_t(edge.opposite[1])], 0.125}}));
  }
  // four triangles each
  for (std::size_t t = 0; t < level.triangles.size(); t++) {
    const auto [a, b, c] = level.triangles[t];
    const auto [ab, bc, ca] = edges_of_triangle[t] + Int3{first, first, first};
    for (const Int3 triangle : {Int3{a, ab, ca}, Int3{ab, b, bc}, Int3{ca, bc, c}, Int3{ab, bc, ca}})
      next.triangles.push_back(triangle);
  }
  return next;
}

}  // namespace

SmoothSurface loop_subdivision(std::span<const Int3> triangles, int levels) {
  TURGOR_ASSERT(levels >= 0, "a surface is subdivided or not");
  // vertices with triangles
  std::vector<int> used;
  for (const Int3 t : triangles) used.insert(used.end(), {t.x, t.y, t.z});
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  const auto number = [&](int v) {
    return int(std::lower_bound(used.begin(), used.end(), v) - used.begin());
  };
  Level level;
  for (const int v : used) level.vertices.push_back({{v, 1}});
  level.on_coarse = level.vertices;
  for (const Int3 t : triangles) level.triangles.push_back({number(t.x), number(t.y), number(t.z)});
  // subdivide
  for (int n = 0; n < levels; n++) level = subdivided(level);
  SmoothSurface surface{.triangles = std::move(level.triangles),
                        .begin = {0},
                        .coarse = {},
                        .weight = {},
                        .on = {},
                        .on_weight = {}};
  for (const Stencil& stencil : level.vertices) {
    for (const auto& [vertex, weight] : stencil)
      surface.coarse.push_back(vertex), surface.weight.push_back(float(weight));
    surface.begin.push_back(int(surface.coarse.size()));
  }
  for (const Stencil& stencil : level.on_coarse) {
    TURGOR_CHECK(stencil.size() >= 1 && stencil.size() <= 3, "a vertex lies on one coarse triangle");
    Int3 corner{stencil[0].first, stencil[0].first, stencil[0].first};
    Vec3 weight;
    for (int n = 0; n < int(stencil.size()); n++)
      corner[n] = stencil[std::size_t(n)].first, weight[n] = Real(stencil[std::size_t(n)].second);
    surface.on.push_back(corner), surface.on_weight.push_back(weight);
  }
  return surface;
}

int levels_for_drawing(std::size_t triangles, std::size_t most) {
  return 16 * triangles < most ? 2 : 4 * triangles < most ? 1 : 0;
}

}  // namespace turgor

#include "turgor/models/cloth/build/numbering.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::cloth {

namespace {

using Graph = std::vector<std::vector<int>>;

Graph make_graph(const std::vector<Spring>& springs, int count) {
  TURGOR_CHECK(std::all_of(springs.begin(), springs.end(),
                           [count](const Spring& s) {
                             return is_index(s.a, std::size_t(count)) && is_index(s.b, std::size_t(count));
                           }),
               "springs join vertices");
  Graph graph(std::size_t(count), std::vector<int>{});
  for (const Spring& s : springs)
    graph[std::size_t(s.a)].push_back(s.b), graph[std::size_t(s.b)].push_back(s.a);
  return graph;
}

/// Breadth-first order of the component of `start`; vertices with few neighbors first.
std::vector<int> breadth_first(const Graph& graph, int start, std::vector<int>& mark, int number) {
  TURGOR_CHECK(is_index(start, graph.size()), "a search starts at a vertex");
  // start the queue
  std::vector<int> order{start};
  mark[std::size_t(start)] = number;
  for (std::size_t n = 0; n < order.size(); n++) {
    // append unvisited neighbors
    const std::size_t begin = order.size();
    for (const int v : graph[std::size_t(order[n])])
      if (mark[std::size_t(v)] != number) mark[std::size_t(v)] = number, order.push_back(v);
    // sort them by degree, then by index
    std::sort(order.begin() + std::ptrdiff_t(begin), order.end(), [&](int a, int b) {
      const std::size_t da = graph[std::size_t(a)].size(), db = graph[std::size_t(b)].size();
      return da != db ? da < db : a < b;
    });
  }
  return order;
}

/// Sum of the index distances of neighbors in an order.
std::int64_t sum_of_distances(const Graph& graph, const std::vector<int>& order, std::vector<int>& index) {
  TURGOR_CHECK(index.size() == graph.size(), "every vertex has an index");
  for (std::size_t n = 0; n < order.size(); n++) index[std::size_t(order[n])] = int(n);
  std::int64_t sum = 0;
  for (const int v : order)
    for (const int w : graph[std::size_t(v)]) sum += std::abs(index[std::size_t(v)] - index[std::size_t(w)]);
  return sum;
}

}  // namespace

Numbering number_vertices(const std::vector<Spring>& springs, int count) {
  constexpr double kGoodEnough = 1.5;  // rows of a grid are contiguous, layers from a corner are not
  const Graph graph = make_graph(springs, count);
  std::vector<int> mark(std::size_t(count), -1), index(std::size_t(count), 0);
  Numbering result;
  int number = 0;
  for (int v = 0; v < count; v++) {
    if (mark[std::size_t(v)] >= 0) continue;
    // order of the mesh, and breadth-first order from a far end
    std::vector<int> component = breadth_first(graph, v, mark, number++);
    const int end =
        breadth_first(graph, component.back(), mark, number++).back();  // about the most distant vertex
    std::vector<int> layers = breadth_first(graph, end, mark, number++);
    std::sort(component.begin(), component.end());
    // better of both
    const double mine = double(sum_of_distances(graph, component, index)),
                 other = double(sum_of_distances(graph, layers, index));
    if (mine > kGoodEnough * other) component = std::move(layers);
    result.component_begin.push_back(int(result.order.size()));
    result.order.insert(result.order.end(), component.begin(), component.end());
  }
  result.component_begin.push_back(count);
  TURGOR_CHECK(is_permutation(result.order, std::size_t(count)), "every vertex is numbered once");
  return result;
}

}  // namespace turgor::cloth

#include "turgor/models/cloth/build/numbering.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace turgor::cloth {

namespace {

using Graph = std::vector<std::vector<int>>;

Graph make_graph(const std::vector<Spring>& springs, int count) {
  Graph graph(std::size_t(count), std::vector<int>{});
  for (const Spring& s : springs)
    graph[std::size_t(s.a)].push_back(s.b), graph[std::size_t(s.b)].push_back(s.a);
  return graph;
}

/// Everything that is connected with `start`, nearest first, those with few neighbours before others.
std::vector<int> spread(const Graph& graph, int start, std::vector<int>& mark, int number) {
  std::vector<int> order{start};
  mark[std::size_t(start)] = number;
  for (std::size_t n = 0; n < order.size(); n++) {
    const std::size_t begin = order.size();
    for (const int v : graph[std::size_t(order[n])])
      if (mark[std::size_t(v)] != number) mark[std::size_t(v)] = number, order.push_back(v);
    std::sort(order.begin() + std::ptrdiff_t(begin), order.end(), [&](int a, int b) {
      const std::size_t da = graph[std::size_t(a)].size(), db = graph[std::size_t(b)].size();
      return da != db ? da < db : a < b;
    });
  }
  return order;
}

/// Sum over neighbours of how far apart they are in an order.
std::int64_t spread_of(const Graph& graph, const std::vector<int>& order, std::vector<int>& place) {
  for (std::size_t n = 0; n < order.size(); n++) place[std::size_t(order[n])] = int(n);
  std::int64_t sum = 0;
  for (const int v : order)
    for (const int w : graph[std::size_t(v)]) sum += std::abs(place[std::size_t(v)] - place[std::size_t(w)]);
  return sum;
}

}  // namespace

Numbering number_vertices(const std::vector<Spring>& springs, int count) {
  constexpr double kGoodEnough = 1.5;  // rows of a grid are contiguous, layers from a corner are not
  const Graph graph = make_graph(springs, count);
  std::vector<int> mark(std::size_t(count), -1), place(std::size_t(count), 0);
  Numbering result;
  int number = 0;
  for (int v = 0; v < count; v++) {
    if (mark[std::size_t(v)] >= 0) continue;
    std::vector<int> part = spread(graph, v, mark, number++);
    const int end = spread(graph, part.back(), mark, number++).back();  // about as far apart as can be
    std::vector<int> layers = spread(graph, end, mark, number++);
    std::sort(part.begin(), part.end());
    const double mine = double(spread_of(graph, part, place)),
                 other = double(spread_of(graph, layers, place));
    if (mine > kGoodEnough * other) part = std::move(layers);
    result.part_begin.push_back(int(result.order.size()));
    result.order.insert(result.order.end(), part.begin(), part.end());
  }
  result.part_begin.push_back(count);
  return result;
}

}  // namespace turgor::cloth

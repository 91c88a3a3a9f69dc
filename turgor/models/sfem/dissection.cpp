#include "turgor/models/sfem/dissection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "turgor/models/sfem/separator.hpp"

namespace turgor::sfem {

namespace {

constexpr std::size_t kLeaf = 8;  // parts of up to so many nodes are not cut
constexpr std::array<Vec3d, 9> kDirections{
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, -1, 0}, {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}}};

struct Dissection {
  const BlockMatrix& k;
  std::span<const Vec3d> x;
  std::vector<int> side;                 // of each node, by the numbers of the last cut it was in
  std::vector<std::uint8_t> is_settled;  // room for refine_separator
  Sides next{0, 1, 2};                   // each cut takes new numbers, so that nothing must be cleared
};

bool touches(const Dissection& d, int node, int side) {
  for (const int other : neighbours(d.k, node))
    if (d.side[std::size_t(other)] == side) return true;
  return false;
}

/// Cuts a part in two equal halves across a direction; the fewer of the nodes that touch the other half come
/// between them. Returns how many these are.
std::size_t cut_across(Dissection& d, std::span<int> part, Vec3d direction, const Sides& sides) {
  const auto along = [&](int node) { return std::pair(dot(d.x[std::size_t(node)], direction), node); };
  const auto middle = part.begin() + std::ptrdiff_t(part.size() / 2);
  std::nth_element(part.begin(), middle, part.end(), [&](int a, int b) { return along(a) < along(b); });
  for (auto node = part.begin(); node != part.end(); node++)
    d.side[std::size_t(*node)] = node < middle ? sides.low : sides.high;
  std::vector<int> low, high;  // borders
  for (auto node = part.begin(); node != part.end(); node++) {
    const bool is_low = node < middle;
    if (touches(d, *node, is_low ? sides.high : sides.low)) (is_low ? low : high).push_back(*node);
  }
  const std::vector<int>& fewer = low.size() <= high.size() ? low : high;
  for (const int node : fewer) d.side[std::size_t(node)] = sides.between;
  return fewer.size();
}

/// Cuts a part where few nodes are between: of the directions that look best, the one that gets best.
void cut(Dissection& d, std::span<int> part, const Sides& sides) {
  constexpr std::size_t kTried = 3;
  std::array<std::pair<std::size_t, std::size_t>, kDirections.size()> rank;  // nodes between, direction
  for (std::size_t i = 0; i < rank.size(); i++) rank[i] = {cut_across(d, part, kDirections[i], sides), i};
  std::sort(rank.begin(), rank.end());
  std::size_t fewest = part.size() + 1;
  std::vector<std::pair<int, int>> best;  // nodes and their sides
  for (std::size_t i = 0; i < kTried; i++) {
    cut_across(d, part, kDirections[rank[i].second], sides);
    const std::size_t between = refine_separator(d.k, part, sides, d.side, d.is_settled);
    if (between >= fewest) continue;
    fewest = between;
    best.clear();
    for (const int node : part) best.emplace_back(node, d.side[std::size_t(node)]);
  }
  for (const auto& [node, side] : best) d.side[std::size_t(node)] = side;
}

/// Orders a part in place: low side, high side, and the nodes between them last.
void dissect(Dissection& d, std::span<int> part) {
  if (part.size() <= kLeaf) {
    std::sort(part.begin(), part.end());
    return;
  }
  const Sides sides = d.next;
  d.next = {sides.low + 3, sides.high + 3, sides.between + 3};
  cut(d, part, sides);
  std::sort(part.begin(), part.end());
  const auto is_on = [&](int side) {
    return [&d, side](int node) { return d.side[std::size_t(node)] == side; };
  };
  const auto high = std::stable_partition(part.begin(), part.end(), is_on(sides.low));
  const auto between = std::stable_partition(high, part.end(), is_on(sides.high));
  if (high == part.begin() || between == high) return;  // held together everywhere: nothing to halve
  dissect(d, {part.begin(), high});
  dissect(d, {high, between});
}

}  // namespace

std::vector<int> nested_dissection(const BlockMatrix& k, std::span<const Vec3d> x) {
  std::vector<int> order(x.size());
  std::iota(order.begin(), order.end(), 0);
  Dissection d{k, x, std::vector<int>(x.size(), -1), std::vector<std::uint8_t>(x.size(), 0)};
  dissect(d, order);
  return order;
}

}  // namespace turgor::sfem

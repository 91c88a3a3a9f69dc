#include "turgor/models/sfem/dissection.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace turgor::sfem {

namespace {

constexpr std::size_t kLeaf = 8;  // parts of up to so many nodes are not cut
constexpr std::array<double, 3> kCuts{0.42, 0.5, 0.58};

struct Cut {
  int axis = 0;
  double place = 0;  // of all nodes of the part, how many are on the low side
  double cost = 0;
};

struct Dissection {
  const BlockMatrix& k;
  std::span<const Vec3d> x;
  std::vector<int> side;  // of each node: which cut it was last in, and where: 3·cut + {0 low, 1 high}
  int cut_count = 0;
};

std::span<const int> neighbours(const BlockMatrix& k, int row) {
  const std::size_t begin = k.row_begin[std::size_t(row)], end = k.row_begin[std::size_t(row) + 1];
  return {&k.column[begin], end - begin};
}

/// Sorts a part along an axis so far that its low side comes first.
std::size_t halve(std::span<int> part, std::span<const Vec3d> x, int axis, double place) {
  const auto low = std::size_t(place * double(part.size()));
  std::nth_element(part.begin(), part.begin() + std::ptrdiff_t(low), part.end(), [&](int a, int b) {
    return std::pair(x[std::size_t(a)][axis], a) < std::pair(x[std::size_t(b)][axis], b);
  });
  return low;
}

/// Numbers the sides of a part; each call takes new numbers, so that nothing must be cleared.
void number_sides(Dissection& d, std::span<const int> part, std::size_t low) {
  d.cut_count++;
  for (std::size_t i = 0; i < part.size(); i++)
    d.side[std::size_t(part[i])] = 2 * d.cut_count + (i < low ? 0 : 1);
}

bool touches(const Dissection& d, int node, int side) {
  for (const int other : neighbours(d.k, node))
    if (d.side[std::size_t(other)] == side) return true;
  return false;
}

/// Nodes of the low side that touch the high side, and the other way round.
std::pair<std::size_t, std::size_t> border_sizes(const Dissection& d, std::span<const int> part,
                                                 std::size_t low) {
  std::size_t low_border = 0, high_border = 0;
  for (std::size_t i = 0; i < low; i++) low_border += touches(d, part[i], 2 * d.cut_count + 1);
  for (std::size_t i = low; i < part.size(); i++) high_border += touches(d, part[i], 2 * d.cut_count);
  return {low_border, high_border};
}

/// The cut with the fewest separating nodes for the balance of its sides.
Cut best_cut(Dissection& d, std::span<int> part) {
  Cut best{0, 0.5, INFINITY};
  for (int axis = 0; axis < 3; axis++)
    for (const double place : kCuts) {
      const std::size_t low = halve(part, d.x, axis, place);
      number_sides(d, part, low);
      const auto [a, b] = border_sizes(d, part, low);
      const double cost = double(std::min(a, b)) / (double(low) * double(part.size() - low));
      if (cost < best.cost) best = {axis, place, cost};
    }
  return best;
}

/// Orders a part in place: low side, high side, and the nodes between them last.
void dissect(Dissection& d, std::span<int> part) {
  if (part.size() <= kLeaf) {
    std::sort(part.begin(), part.end());
    return;
  }
  const Cut cut = best_cut(d, part);
  const std::size_t low = halve(part, d.x, cut.axis, cut.place);
  number_sides(d, part, low);
  const auto [a, b] = border_sizes(d, part, low);
  const int from = 2 * d.cut_count + (a <= b ? 0 : 1), to = from ^ 1;
  const auto separates = [&](int node) { return d.side[std::size_t(node)] == from && touches(d, node, to); };
  const auto separator =
      std::stable_partition(part.begin(), part.end(), [&](int node) { return !separates(node); });
  const auto high = std::stable_partition(
      part.begin(), separator, [&](int node) { return d.side[std::size_t(node)] == 2 * d.cut_count; });
  std::sort(separator, part.end());
  dissect(d, {part.begin(), high});
  dissect(d, {high, separator});
}

}  // namespace

std::vector<int> nested_dissection(const BlockMatrix& k, std::span<const Vec3d> x) {
  std::vector<int> order(x.size());
  std::iota(order.begin(), order.end(), 0);
  Dissection d{k, x, std::vector<int>(x.size(), -1)};
  dissect(d, order);
  return order;
}

}  // namespace turgor::sfem
